# %% [markdown]
# # Tuning a mass damper with exact gradients
# A tower that sways under random wind carries a small mass on a spring and a damper. Which spring
# and damper let it sway least? The mean square of the sway follows from the linear equations by one
# Lyapunov equation, its gradient from another and the exact derivatives of A: no differences.
#
# Warburton ("Optimum absorber parameters for various combinations of response and excitation
# parameters", Earthquake Engineering and Structural Dynamics 10, 1982, table I) has the answer in
# closed form for an undamped tower.

# %%
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.analysis import Linearizer, frequency_response
from m4e_fmi.model import Body, Joint, Model, Parameter, Point, TensionDamper, TensionSpring

WIND, SWAY = "body.tower.force_x", "joint.sway.q"
DESIGN: tuple[str, ...] = ("k", "c")
MASS, STIFFNESS, RATIO = 1.0e5, 4.0e5, 0.05  # kg, N/m, mass of the damper by that of the tower


def model() -> Model:
    """The tower's top as one mass of its first mode; the damper slides on it."""
    return Model(
        name="tuned_mass_damper",
        gravity=0.0,
        parameters={
            "k": Parameter(RATIO * STIFFNESS, "N/m", "Stiffness of the damper's spring"),
            "c": Parameter(0.1 * RATIO * MASS, "N.s/m", "Damping of the damper"),
        },
        bodies={"tower": Body(MASS, 1.0), "damper": Body(RATIO * MASS, 1.0)},
        joints={
            "sway": Joint("prismatic", "tower", direction=(1, 0)),
            "slide": Joint("prismatic", "damper", "tower", direction=(1, 0)),
        },
        points={
            "foot": Point("ground", (-20, 0)),
            "top": Point("tower", (0, 0)),
            "wall": Point("tower", (-5, 0)),
            "eye": Point("damper", (0, 0)),
        },
        loads={
            "tower": TensionSpring(("foot", "top"), STIFFNESS, 20.0),
            "spring": TensionSpring(("wall", "eye"), "k", 5.0),
            "damper": TensionDamper(("wall", "eye"), "c"),
        },
    )


# %% [markdown]
# White noise w of unit density drives δẋ = A δx + B w. The covariance P solves
# A P + P Aᵀ + B Bᵀ = 0 and the mean square of y = C x is J = C P Cᵀ. With Aᵀ Q + Q A + Cᵀ C = 0 its
# derivative is dJ = 2 tr(Q dA P), since B does not depend on the design.


# %%
class MeanSquare:
    """ln J and its gradient, by the logarithms of the design."""

    def __init__(self) -> None:
        self.linearizer = Linearizer(model(), inputs=[WIND], outputs=[SWAY])

    def __call__(self, logarithms: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        from scipy.linalg import solve_continuous_lyapunov

        design = dict(zip(DESIGN, np.exp(logarithms).tolist(), strict=True))
        linear = self.linearizer.at(design)
        covariance = solve_continuous_lyapunov(linear.A, -linear.B @ linear.B.T)
        weight = solve_continuous_lyapunov(linear.A.T, -linear.C.T @ linear.C)
        value = float((linear.C @ covariance @ linear.C.T)[0, 0])
        slopes = [
            2 * np.trace(weight @ self.linearizer.change(linear.point, {name: 1.0}) @ covariance)
            for name in DESIGN
        ]
        gradient = np.array(slopes) * np.exp(logarithms) / value
        return np.log(value), gradient


def optimum() -> dict[str, float]:
    """The best spring [N/m] and damper [N·s/m], from a start far off."""
    from scipy.optimize import minimize

    start = [p.value for p in model().parameters.values()]
    found = minimize(MeanSquare(), np.log(start), jac=True, method="BFGS", options={"gtol": 1e-10})
    return dict(zip(DESIGN, np.exp(found.x).tolist(), strict=True))


def warburton() -> dict[str, float]:
    """The closed form: f² = (1 + μ/2)/(1 + μ)², ζ² = μ (1 + 3μ/4)/(4 (1 + μ)(1 + μ/2))."""
    mu, omega = RATIO, np.sqrt(STIFFNESS / MASS)
    tuned = omega * np.sqrt(1 + mu / 2) / (1 + mu)
    ratio = np.sqrt(mu * (1 + 0.75 * mu) / (4 * (1 + mu) * (1 + 0.5 * mu)))
    return {"k": mu * MASS * tuned**2, "c": 2 * ratio * mu * MASS * tuned}


# %%
def picture(designs: dict[str, dict[str, float]], path: Path) -> None:
    """How the tower answers a harmonic force, by design."""
    from matplotlib.figure import Figure

    omega = np.linspace(1.2, 2.8, 600)
    linearizer = Linearizer(model(), inputs=[WIND], outputs=[SWAY])
    figure = Figure(figsize=(7, 4), layout="constrained")
    axis = figure.subplots()
    for (label, design), colour in zip(designs.items(), ("#9aa5ae", "#d1495b"), strict=True):
        response = np.abs(frequency_response(linearizer.at(design), omega).of(SWAY, WIND))
        axis.plot(omega, STIFFNESS * response, color=colour, label=label)
    axis.set_xlabel("angular frequency [rad/s]")
    axis.set_ylabel("sway by static sway [1]")
    axis.set_title("A tower with a tuned mass damper of 5 % of its mass")
    axis.legend(frameon=False)
    axis.spines[["top", "right"]].set_visible(False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130)


def main() -> None:
    """Optimise, compare, draw."""
    found, closed = optimum(), warburton()
    for name in DESIGN:
        print(f"{name} = {found[name]:.6f}, closed form {closed[name]:.6f}")
    start = {name: p.value for name, p in model().parameters.items()}
    picture({"first guess": start, "optimum": found}, Path("build/tuned_mass_damper.png"))
    print("wrote build/tuned_mass_damper.png")


# %%
if __name__ == "__main__":
    main()
