"""A convergence study as JSON and as a picture, for `m4e-fmi hydro --refine`."""

from __future__ import annotations

import math
from pathlib import Path

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


def plot_refinement(study: Refinement, picture: Path) -> Path:
    """Draw A, B and |X| of each motion for all meshes and their limit; InputError for a suffix."""
    from matplotlib.figure import Figure

    from m4e_fmi.report.drawing.pictures import check_picture_path, save
    from m4e_fmi.report.drawing.style import COLOURS, GREY, GRID

    check_picture_path(picture)
    names = study.limit.motions
    shown = study.limit.omega <= study.highest
    figure = Figure(figsize=(11, 0.6 + 2.2 * len(names)), layout="constrained")
    axes = figure.subplots(len(names), 3, squeeze=False, sharex=True)
    tables = [*zip(map(str, study.panels), study.meshes, strict=True), ("limit", study.limit)]
    for row, name in enumerate(names):
        for column, symbol in enumerate("ABX"):
            axis = axes[row, column]
            for k, (label, c) in enumerate(tables):
                values = (
                    c.added_mass[:, row, row],
                    c.radiation_damping[:, row, row],
                    np.abs(c.excitation[:, row]),
                )[column]
                last = label == "limit"
                axis.plot(
                    c.omega[shown],
                    values[shown],
                    "-" if last else "o",
                    ms=3,
                    lw=1.2,
                    color=GREY if last else COLOURS[k % len(COLOURS)],
                    label=label if last else f"{label} panels",
                )
                if column == 0:
                    axis.axhline(
                        c.added_mass_inf[row, row],
                        ls=":",
                        lw=0.8,
                        color=GREY if last else COLOURS[k % len(COLOURS)],
                    )
            axis.grid(color=GRID, lw=0.6)
            axis.set_title(f"{symbol} {name}" if symbol != "X" else f"|X| {name}", fontsize=9)
    for axis in axes[-1]:
        axis.set_xlabel("frequency [rad/s]", fontsize=9)
    axes[0, 0].legend(fontsize=8, frameon=False, title="dotted: at infinity", title_fontsize=8)
    return save(figure, picture)
