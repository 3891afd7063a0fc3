# %% [markdown]
# # The double pendulum in Python
# The model of `double_pendulum.model.yaml`, said in Python, simulated in process and as an FMU.

# %%
from pathlib import Path

from m4e_fmi.model import (
    Body,
    BodyForce,
    Joint,
    Model,
    Parameter,
    Point,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.multibody import Equations, model_program
from m4e_fmi.simulate import simulate

LINK = Body(mass="m", inertia="J")


def model() -> Model:
    """Sabet and Diaz-Flores Caminero, "Multibody for Everybody", section 5.1."""
    return Model(
        name="double_pendulum",
        description="Two links, pushed at the lower one, held back by a torsion spring and dampers",
        gravity=9.81,
        parameters={
            "m": Parameter(1, "kg", "Mass of a link"),
            "J": Parameter(1, "kg.m2", "Inertia of a link about its centre of gravity"),
            "L": Parameter(1, "m", "Length of a link"),
            "k": Parameter(50, "N.m/rad", "Stiffness of the torsion spring at the shoulder"),
            "c": Parameter(5, "N.m.s/rad", "Damping of the torsion damper at each joint"),
        },
        bodies={"upper": LINK, "lower": LINK},
        joints={
            "shoulder": Joint(
                "revolute",
                child="upper",
                joint_to_child=(0, "-L/2"),
                initial={"q": "0.75*pi", "u": -0.4},
            ),
            "elbow": Joint(
                "revolute",
                parent="upper",
                child="lower",
                parent_to_joint=(0, "-L/2"),
                joint_to_child=(0, "-L/2"),
            ),
        },
        points={"tip": Point("lower", at=(0, "-L/2"))},
        loads={
            "push": BodyForce("lower", force=(20, 20)),
            "spring": TorsionSpring(("ground", "upper"), stiffness="k", angle="-0.75*pi"),
            "shoulder_damper": TorsionDamper(("ground", "upper"), damping="c"),
            "elbow_damper": TorsionDamper(("upper", "lower"), damping="c"),
        },
    )


def main() -> None:
    """Print the equations and the end of ten seconds; write the FMU."""
    from m4e_fmi.fmu import build_fmu

    pendulum = model()
    print(Equations(pendulum).text())
    result = simulate(pendulum, stop_time=10.0)
    print(f"Theta_2(10 s) = {result['joint.elbow.q'][-1]:.6f} rad")
    print("wrote", build_fmu(model_program(pendulum), Path("build/double_pendulum.fmu")))


# %%
if __name__ == "__main__":
    main()
