"""A small model in space with a ball joint and a free body: two quaternions among its states."""

from __future__ import annotations

from m4e_fmi.model import Body, Bushing, Joint, Model, Point


def crane() -> Model:
    """A turning arm with a load on a ball joint, and a free hull on a spring."""
    return Model(
        "crane",
        {
            "arm": Body(2.0, (1.0, 2.0, 1.5)),
            "load": Body(1.0, (0.2, 0.3, 0.25, 0.02, 0.01, 0.03)),
            "hull": Body(3.0, (1.0, 1.2, 1.4)),
        },
        {
            "swing": Joint("revolute", "arm", axis=(0.2, 0, 1), joint_to_child=(1, 0, 0)),
            "hook": Joint(
                "spherical", "load", "arm", (1, 0, 0), (0, 0.1, -1),
                initial={"phi": 0.3, "psi": 0.5, "omega": 0.4},
            ),
            "sea": Joint("floating", "hull", initial={"theta": 0.2, "vy": 0.3, "omega_z": 0.5}),
        },
        points={"deck": Point("hull", (0.5, 0.2, 0.3)), "buoy": Point("ground", (0, 0, 1))},
        loads={"line": Bushing(("deck", "buoy"), 20.0, 1.0)},
        dimensions=3,
    )  # fmt: skip
