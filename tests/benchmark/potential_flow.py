"""Potential flow of one hull, by `ours` or by a `script` that calls Capytaine: its own process.

    python -m benchmark.potential_flow ours|script|default deep|DEPTH PANELS FREQUENCIES

Both solve the same problems, six motions and the same wave directions, on the same mesh with its
planes of symmetry, and end with coefficients. The `script` has our accurate kernel of finite depth,
the `default` has Capytaine's. Prints wall time and processor time [s], after the table of the
Green function has been read. With `ours`, a line for each frequency, as it is done.
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from ruamel.yaml import YAML

from benchmark.hydrodynamics import HULL
from m4e_adapters.hydrodynamics.build import make_hulls
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Water
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls, wave_directions
from m4e_adapters.hydrodynamics.flow.capytaine_setup import accurate_finite_depth, import_capytaine
from m4e_adapters.hydrodynamics.flow.flow_solver import METHOD, capytaine_body
from m4e_adapters.hydrodynamics.geometry.mesh import Hull

LIMITS = (0.25, 2.2)  # rad/s


def script(hulls: Sequence[Hull], water: Water, omega: np.ndarray) -> Any:
    """A dataset, as a user of Capytaine makes it."""
    capytaine = import_capytaine()
    body = capytaine_body(capytaine, hulls)
    medium = {"water_depth": water.depth, "rho": water.density, "g": water.gravity}
    problems = []
    for w in [*omega.tolist(), np.inf]:
        common = {"body": body, "omega": w, **medium}
        problems += [capytaine.RadiationProblem(radiating_dof=d, **common) for d in body.dofs]
        problems += [
            capytaine.DiffractionProblem(wave_direction=np.radians(beta), **common)
            for beta in wave_directions(hulls, water, w, 0.0)
        ]
    solver = capytaine.BEMSolver(method=METHOD)
    results = solver.solve_all(
        problems, keep_details=False, progress_bar=False, _check_wavelength=False
    )
    return capytaine.assemble_dataset(results, hydrostatics=False)


def main(who: str, depth: str, panels: int, count: int) -> None:
    config = HydrodynamicsConfig.model_validate(YAML(typ="safe").load(HULL % (panels, depth)))
    hulls = make_hulls(config, Path(), progress=lambda _: None)
    omega = np.linspace(*LIMITS, count)
    capytaine = import_capytaine()
    capytaine.BEMSolver(method=METHOD)  # reads the table
    print(len(hulls[0].panels.faces), "panels", flush=True)
    wall, spent = time.perf_counter(), time.process_time()
    if who == "ours":

        def told(text: str) -> None:
            print(text, flush=True)

        solve_hulls(hulls, water=config.water, omega=omega, progress=told)
    else:
        with accurate_finite_depth() if who == "script" else contextlib.nullcontext():
            script(hulls, config.water, omega)
    print(time.perf_counter() - wall, time.process_time() - spent)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
