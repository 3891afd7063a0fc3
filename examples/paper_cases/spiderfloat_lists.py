# %% [markdown]
# # SpiderFLOAT, as the paper types it
# The listing of S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody", section 5.2,
# turned into a model: its tables, equations, drawing, and an animation of ten seconds.

# %%
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sym

from m4e_fmi.model import Model, model_from_lists
from m4e_fmi.multibody import Equations
from m4e_fmi.report import animate, draw_model, model_tables
from m4e_fmi.simulate import Simulation, simulate

nan = [np.nan, np.nan]
t = sym.Symbol("t")

joints = [[0, 1], [1, 2], [1, 3], [2, 4], [3, 5], [4, 6], [5, 7]]
types = ["F", "R", "R", "P", "P", "R", "R"]
parent_cg_to_joint = [[10, 6], [0.5, -2], [-0.5, -2], [4.5, 0], [-4.5, 0], [0, 0], [0, 0]]
joint_to_child_cg = [nan, [5, 0], [-5, 0], [0.5, 0], [-0.5, 0], [0, 1.5], [0, 1.5]]
prismatic_direction = [nan, nan, nan, [1, 0], [1, 0], nan, nan]

Initial_Points: dict[str, Any] = {"GR": [[20, 0], [0, 0]], "BD": {}}
Initial_Points["BD"][1] = [[0.5, -2.5], [-0.5, -2.5], [0.5, 5], [-0.5, 5]]
Initial_Points["BD"][2] = [[4, 0], [4.5, 0]]
Initial_Points["BD"][3] = [[-4, 0], [-4.5, 0]]

Force: dict[str, Any] = {}
Force["CG"] = [[1, 0, sym.cos(t), 0], [4, sym.cos(t), 0, 0], [5, -sym.cos(t), 0, 0]]
Force["TensionSpring"] = [
    (("BD10", "BD20"), [9.0139, 1e-1]),
    (("BD11", "BD30"), [9.0139, 1e-1]),
    (("BD12", "BD21"), [11.8004, 1e-1]),
    (("BD13", "BD31"), [11.8004, 1e-1]),
    (("BD20", "GR00"), [3.0414, 1e-1]),
    (("GR01", "BD30"), [3.0414, 1e-1]),
]
Force["TensionDamper"] = [(("GR00", "CG22"), 3), (("GR01", "CG33"), 3)]
Force["TorsionSpring"] = [((1, 2), [0, 1e2]), ((1, 3), [0, 1e2])]
Force["TorsionDamper"] = [((1, 2), 1e1), ((1, 3), 1e1)]

g = 0.0
m0 = np.ones(len(types))
J0 = 2 * np.ones(len(types))


# %%
def model() -> Model:
    """The model of the lists above."""
    return model_from_lists(globals(), name="spiderfloat", description="Sections 4.2.3 and 5.2")


def simulation() -> Simulation:
    """Ten seconds from rest."""
    return simulate(model(), stop_time=10.0, output_interval=0.02)


def main() -> None:
    """Print tables and mass matrix; write the drawing and the animation."""
    print(model_tables(model()))
    print("M[4,4] =", Equations(model()).mass_matrix[3, 3])
    result = simulation()
    print(f"right slider at t = 10 s: {result['joint.joint_4.q'][-1]:.6f} m")
    print("wrote", draw_model(model(), Path("build/spiderfloat_model.png")))
    print("wrote", animate(model(), result, Path("build/spiderfloat.html")))


# %%
if __name__ == "__main__":
    main()
