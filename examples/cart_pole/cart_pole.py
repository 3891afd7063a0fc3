# %% [markdown]
# # A cart balances a pole
# Linear equations about the upright equilibrium, a linear-quadratic regulator from python-control,
# and the nonlinear system under its feedback.

# %%
from pathlib import Path

import numpy as np

from m4e_fmi.analysis import Linearization, equilibrium, linearize, modes
from m4e_fmi.model import Body, Joint, Model, Parameter, Point
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, with_feedback
from m4e_fmi.simulate import Simulation, simulate

PUSH = "joint.rail.effort"
TILT = 0.6  # rad, 34° from upright
STATES = ("joint.rail.q", "joint.pivot.q", "joint.rail.u", "joint.pivot.u")
STATE_WEIGHTS = (1.0, 10.0, 1.0, 1.0)
INPUT_WEIGHT = 0.1


def model() -> Model:
    """A cart on a rail, a uniform pole on it that stands for θ = 0."""
    return Model(
        name="cart_pole",
        gravity=9.81,
        parameters={
            "M": Parameter(1.0, "kg", "Mass of the cart"),
            "m": Parameter(0.2, "kg", "Mass of the pole"),
            "L": Parameter(1.0, "m", "Length of the pole"),
        },
        bodies={"cart": Body("M", 0.01), "pole": Body("m", "m*L**2/12")},
        joints={
            "rail": Joint("prismatic", "cart", direction=(1, 0)),
            "pivot": Joint("revolute", "pole", "cart", joint_to_child=(0, "L/2")),
        },
        points={"tip": Point("pole", (0, "L/2"))},
    )


# %% [markdown]
# About the upright equilibrium one eigenvalue is positive: the pole falls. The regulator minimises
# ∫ xᵀQx + r F² dt.


# %%
def upright() -> Linearization:
    """Linear equations with the force on the cart as input."""
    # it stands at the start, so the nearest equilibrium is the one where it stands
    return linearize(model(), at=equilibrium(model(), nearest=True), inputs=[PUSH])


def regulator(linear: Linearization) -> np.ndarray:
    """K of F = −K x, in the order of the linear equations' states."""
    import control

    assert tuple(v.name for v in linear.states) == STATES
    gain, _, _ = control.lqr(linear.A, linear.B, np.diag(STATE_WEIGHTS), [[INPUT_WEIGHT]])
    return np.asarray(gain)[0]


# %% [markdown]
# The feedback becomes part of the program: what runs is the nonlinear system, and it can be
# exported, linearised and differentiated like any other.


# %%
def closed_loop(gain: np.ndarray) -> Program:
    """The nonlinear system under F = −K x."""

    def force(values):
        return -sum(k * values[name] for k, name in zip(gain.tolist(), STATES, strict=True))

    return with_feedback(model_program(model()), {PUSH: force})


def balanced(program: Program) -> Simulation:
    """Six seconds from the tilt."""
    start = {"joint.pivot.q": TILT}
    return simulate(program, stop_time=6.0, start_values=start, tolerance=1e-10)


# %%
def picture(run: Simulation, path: Path) -> None:
    """The pole's angle, the cart's way and its force."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 5), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True)
    rows = (
        ("pole [°]", np.degrees(run["joint.pivot.q"])),
        ("cart [m]", run["joint.rail.q"]),
        ("force [N]", run[PUSH]),
    )
    for axis, (label, values) in zip(axes, rows, strict=True):
        axis.plot(run.time, values, color="#1f5f8b")
        axis.axhline(0.0, color="#9aa5ae", linewidth=0.7)
        axis.set_ylabel(label)
        axis.spines[["top", "right"]].set_visible(False)
    figure.align_ylabels()
    axes[-1].set_xlabel("time [s]")
    axes[0].set_title(f"Cart and pole from {np.degrees(TILT):.0f}°, linear-quadratic regulator")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130)


def main() -> None:
    """Design, simulate, draw."""
    linear = upright()
    gain = regulator(linear)
    print("eigenvalues without control:", np.round(modes(linear).eigenvalues, 3))
    print("gains:", dict(zip(STATES, np.round(gain, 3).tolist(), strict=True)))
    program = closed_loop(gain)
    print("with it:", np.round(modes(linearize(program)).eigenvalues, 3))
    run = balanced(program)
    print(f"the cart needs {np.ptp(run['joint.rail.q']):.4f} m")
    picture(run, Path("build/cart_pole.png"))
    print("wrote build/cart_pole.png")


# %%
if __name__ == "__main__":
    main()
