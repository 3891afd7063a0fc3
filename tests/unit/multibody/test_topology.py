"""Numbering of bodies and coordinates."""

from __future__ import annotations

from m4e_fmi.model import Body, Joint, Model
from m4e_fmi.model.elements import AngleReference
from m4e_fmi.multibody import Topology, topology

PARENTS = {
    "hull": ("ground", "floating"),
    "arm": ("hull", "revolute"),
    "slide": ("hull", "prismatic"),
    "flap": ("slide", "revolute"),
    "foot": ("slide", "prismatic"),
    "wall": ("ground", "prismatic"),
    "knob": ("wall", "prismatic"),
}


def tree_of(order: list[str], joint_order: list[str] | None = None) -> Topology:
    def joint(child: str) -> Joint:
        parent, kind = PARENTS[child]
        direction = (1.0, 0.0) if kind == "prismatic" else None
        return Joint(kind, child, parent, direction=direction)

    bodies = {body: Body(1.0, 1.0) for body in order}
    joints = {f"to_{body}": joint(body) for body in joint_order or order}
    return topology(Model(name="tree", bodies=bodies, joints=joints))


def test_bodies_and_coordinates_are_numbered_by_distance_then_in_the_order_of_the_model() -> None:
    tree = tree_of(["flap", "wall", "foot", "arm", "hull", "knob", "slide"])
    numbered = [link.body for link in tree.links]
    assert numbered == ["wall", "hull", "arm", "knob", "slide", "flap", "foot"]
    tree = tree_of(list(PARENTS))
    numbered = [link.body for link in tree.links]
    assert numbered == ["hull", "wall", "arm", "slide", "knob", "flap", "foot"]
    names = ("X_1", "Z_1", "Theta_1", "S_2", "Theta_3", "S_4", "S_5", "Theta_6", "S_7")
    assert tree.coordinate_names == names
    assert tree.velocity_names == tuple(name.replace("_", "D_") for name in names)
    turned = {
        link.body: " + ".join(tree.coordinate_names[k] for k in link.angles) for link in tree.links
    }
    nearest = {"hull": "Theta_1", "arm": "Theta_3", "flap": "Theta_6", "wall": "", "knob": ""}
    assert turned == {**nearest, "slide": "Theta_1", "foot": "Theta_1"}
    branches = [["hull", "arm"], ["hull", "slide", "flap"], ["hull", "slide", "foot"],
                ["wall", "knob"]]  # fmt: skip
    assert sorted(tree.branches()) == branches


def test_relative_angles_are_summed_up_to_the_nearest_absolute_one() -> None:
    def hinge(child: str, parent: str, coordinate: AngleReference) -> Joint:
        return Joint("revolute", child, parent, coordinate=coordinate)

    joints = {
        "a": hinge("one", "ground", "relative"),
        "b": hinge("two", "one", "relative"),
        "c": Joint("fixed", "three", "two"),
        "d": hinge("four", "three", "relative"),
        "e": hinge("five", "four", "absolute"),
        "f": Joint("fixed", "post"),
    }
    bodies = {name: Body(1.0, 1.0) for name in ("one", "two", "three", "four", "five", "post")}
    tree = topology(Model(name="chain", bodies=bodies, joints=joints))
    assert tree.coordinate_names == ("Phi_1", "Phi_3", "Phi_5", "Theta_6")
    assert tree.velocity_names == ("PhiD_1", "PhiD_3", "PhiD_5", "ThetaD_6")
    angles = {link.body: link.angles for link in tree.links}
    assert angles == {
        "one": (0,),
        "post": (),
        "two": (0, 1),
        "three": (0, 1),
        "four": (0, 1, 2),
        "five": (3,),
    }
