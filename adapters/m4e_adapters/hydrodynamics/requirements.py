"""Requirements of this adapter on a machine, for `m4e-fmi doctor`."""

from __future__ import annotations

import tempfile
from importlib.metadata import version

from m4e_adapters.hydrodynamics.flow.cache import ENVIRONMENT, cache_folder

REINSTALL = "reinstall it: pip install --force-reinstall capytaine"


def requirements() -> list[tuple[str, bool, str]]:
    """Name, presence, and a detail or a remedy of each requirement."""
    return [_core(), _cache()]


def _core() -> tuple[str, bool, str]:
    """Solve the infinite-frequency heave of a small ball with the compiled kernels."""
    what = "capytaine (potential flow)"
    try:
        from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine, kept_warnings

        with kept_warnings():
            capytaine = import_capytaine()
            mesh = capytaine.mesh_sphere(resolution=(4, 8)).immersed_part()
            dofs = capytaine.rigid_body_dofs(only=["Heave"])
            body = capytaine.FloatingBody(mesh=mesh, dofs=dofs)
            problem = capytaine.RadiationProblem(
                body=body, radiating_dof="Heave", omega=float("inf")
            )
            solver = capytaine.BEMSolver(method="direct")
            mass = solver.solve(problem, keep_details=False).added_masses["Heave"]
    except Exception as error:  # noqa: BLE001  a broken binary may raise anything
        return what, False, f"{type(error).__name__}: {error}; {REINSTALL}"
    if not mass > 0:
        return what, False, f"it computes nonsense (added mass {mass}); {REINSTALL}"
    return what, True, f"version {version('capytaine')}, solves"


def _cache() -> tuple[str, bool, str]:
    what = "cache of hydrodynamic coefficients"
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder):
            pass
    except OSError as error:
        return what, False, f"{folder}: {error.strerror}; set {ENVIRONMENT} to a writable folder"
    return what, True, str(folder)
