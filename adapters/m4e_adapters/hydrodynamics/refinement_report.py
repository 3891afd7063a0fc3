"""A convergence study as JSON, for `m4e-fmi hydro --refine`."""

from __future__ import annotations

import math

import numpy as np

from m4e_adapters.hydrodynamics.refinement import Refinement


def refinement_json(study: Refinement) -> dict[str, object]:
    """Panels of the meshes, and a row for each coefficient; the limit's tables in SI."""
    rows = [
        {
            "quantity": row.quantity,
            "motions": row.motions,
            "largest": row.largest,
            "errors": list(row.errors),
            "error_of_limit": row.remaining,
            "order": None if math.isnan(row.order) else row.order,
        }
        for row in study.rows()
    ]
    limit = study.limit
    return {
        "panels": list(study.panels),
        "highest_frequency": study.highest,
        "rows": rows,
        "motions": list(limit.motions),
        "omega": limit.omega.tolist(),
        "added_mass": limit.added_mass.tolist(),
        "radiation_damping": limit.radiation_damping.tolist(),
        "added_mass_inf": limit.added_mass_inf.tolist(),
        "excitation_real": np.real(limit.excitation).tolist(),
        "excitation_imaginary": np.imag(limit.excitation).tolist(),
    }
