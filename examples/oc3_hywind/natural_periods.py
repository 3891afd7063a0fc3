# %% [markdown]
# # Natural periods of a floating wind turbine
# OC3-Hywind is a spar with the NREL 5-MW turbine on three catenary lines. Its six natural periods
# and their damping follow from linear equations of the three parts of `system.yaml`, put together:
# the body's from its model, those of the water from the program of the hydrodynamics, radiation
# memory included, and the stiffness of the lines from their static equilibria.

# %%
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from m4e_adapters.hydrodynamics import HydrodynamicsConfig, program_from_config
from m4e_adapters.moordyn import MooringConfig, mooring
from m4e_adapters.moordyn.statics import Net
from m4e_fmi.analysis import linearize
from m4e_fmi.cosim import load_system
from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.program import Program
from m4e_fmi.runtime.engine import Engine

FOLDER = Path(__file__).parent
MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
PLACES = ("x", "y", "z", "phi", "theta", "psi")
SPEEDS = ("vx", "vy", "vz", "omega_x", "omega", "omega_z")
FORCES = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
FAIRLEADS = ("fairlead_1", "fairlead_2", "fairlead_3")
SEGMENTS = 100  # of a line, for its static stiffness
OFFSET = 0.5  # m, to both sides, for the stiffness of a line
LEVER = 60.0  # m, by which rotations count as motions when a mode is named


class Mode(NamedTuple):
    """A motion that decays: its period 2π/|λ| [s] and its damping ratio −Re λ/|λ|."""

    period: float
    damping_ratio: float


def configured(kind: str) -> Any:
    """The configuration of one of the components in the system file."""
    sources = [component.source for component in load_system(FOLDER / "system.yaml").components]
    return next(s.config for s in sources if isinstance(s, Kind) and s.name == kind)


def hydrodynamics() -> Program:
    """The load of the still water on the spar."""
    config = configured("hydrodynamics")
    assert isinstance(config, HydrodynamicsConfig)
    return program_from_config(config, name="hydro", folder=FOLDER)


# %% [markdown]
# A line that moves slowly is in static equilibrium; the three forces on a fairlead are then
# functions of its place.


# %%
def pulls(places: np.ndarray) -> np.ndarray:
    """Forces (3, 3) [N] of the resting lines on the fairleads at `places` (3, 3) [m]."""
    config = configured("mooring")
    assert isinstance(config, MooringConfig)
    finer = {
        name: line.model_copy(update={"segments": SEGMENTS}) for name, line in config.lines.items()
    }
    net = Net(mooring(config.model_copy(update={"lines": finer})).net, places)
    assert net.settle()
    return net.end_forces()[:, 1]


def line_stiffness(places: np.ndarray) -> np.ndarray:
    """−∂(forces)/∂(places) (9, 9) [N/m] of the fairleads; a line feels its own one only."""
    result = np.zeros((9, 9))
    for axis, step in enumerate(OFFSET * np.eye(3)):
        change = (pulls(places - step) - pulls(places + step)) / (2 * OFFSET)
        for k in range(3):
            result[3 * k : 3 * k + 3, 3 * k + axis] = change[k]
    return result


# %% [markdown]
# The forces on the body have their values at rest, so that buoyancy and pull of the lines do their
# part where it turns. Its weight is in its own equations.


# %%
def state_matrix() -> np.ndarray:
    """A of ẋ = A x: places and small rotations, velocities (6 each), states of the memory."""
    program = hydrodynamics()
    water = linearize(
        program,
        inputs=[f"spar.{name}" for name in (*PLACES, *SPEEDS)],
        outputs=[f"spar.{name}" for name in FORCES],
    )
    on_spar = [f"body.spar.{name}" for name in FORCES]
    on_lines = [f"point.{name}.force_{axis}" for name in FAIRLEADS for axis in "xyz"]
    seen = [f"point.{name}.{axis}" for name in FAIRLEADS for axis in "xyz"]
    names = [v.name for v in program.calculated]
    added_mass = zip(names, Engine(program).calculated(), strict=True)
    at = {name: value for name, value in added_mass if name.startswith("added_mass")}
    at |= dict(zip(on_spar, water.values, strict=True))
    model = FOLDER / "hywind.model.yaml"
    places = linearize(model, at=at, outputs=seen).values.reshape(3, 3)
    at |= dict(zip(on_lines, pulls(places).ravel(), strict=True))
    body = linearize(model, at=at, inputs=[*on_spar, *on_lines], outputs=seen)
    by_water, by_lines = body.B[:, :6], body.B[:, 6:]
    stiffness = line_stiffness(places)
    return np.block(
        [
            [body.A + by_water @ water.D - by_lines @ stiffness @ body.C, by_water @ water.C],
            [water.B, water.A],
        ]
    )


def modes() -> dict[str, Mode]:
    """The six slow oscillations, each named by the motion that is largest in it."""
    values, vectors = map(np.asarray, np.linalg.eig(state_matrix()))
    found = {}
    for k in np.argsort(abs(values)):
        value = complex(values[k])
        ratio = -value.real / abs(value)
        if value.imag <= 0 or ratio > 0.5:  # the other of a pair, or the memory
            continue
        sizes = abs(vectors[:6, k]) * [1, 1, 1, LEVER, LEVER, LEVER]
        motion = MOTIONS[int(np.argmax(sizes))]
        found.setdefault(motion, Mode(2 * np.pi / abs(value), ratio))
    return found


# %%
if __name__ == "__main__":
    print("            period   damping ratio")
    for name, mode in modes().items():
        print(f"{name:6} {mode.period:10.2f} s {100 * mode.damping_ratio:8.2f} %")
