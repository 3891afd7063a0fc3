"""Accelerations of 200 random trees in space beside Pinocchio's articulated-body algorithm.

Trees have all joints, arbitrary axes and inertias, and forces and moments on every body. Joints
with several axes are chains of Pinocchio's joints with bodies without mass between them. The
accelerations of all bodies are compared: where the joints are, Pinocchio's coordinates are others.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin
from support.programs import Evaluated
from support.spatial_trees import spatial_tree

from m4e_fmi.model import Model
from m4e_fmi.model.elements import parameter_values, vector
from m4e_fmi.multibody import Topology, topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.recursion import Recursion

TREES, LIMIT = 200, 1e-12
Matrix = np.ndarray
PARTS = ("ax", "ay", "az", "alpha_x", "alpha", "alpha_z")


class Peer:
    """A model as one of Pinocchio's, and its state there."""

    def __init__(self, model: Model, tree: Topology, found: Mapping[str, float]) -> None:
        self.model, self.tree, self.found = model, tree, found
        self.values = parameter_values(model.parameters)
        self.peer = pin.Model()
        given = model.gravity
        if isinstance(given, tuple):
            self.peer.gravity.linear = self.vector(model, "gravity")
        else:
            self.peer.gravity.linear = np.array([0, 0, -self.number(given)])
        self.q: list[float] = []
        self.v: list[float] = []
        self.holders: list[tuple[int, Any]] = []  # joint, and the CG in its frame
        for link in tree.links:
            self._add(link)

    def number(self, quantity: Any) -> float:
        return float(self.values.get(quantity, quantity))

    def vector(self, owner: object, name: str) -> Matrix:
        found = [part.evaluate(self.values) for part in vector(owner, name)]
        return np.array(found if len(found) == 3 else [0.0, 0.0, 0.0], float)

    def rotation(self, body: str) -> Matrix:
        if body == "ground":
            return np.eye(3)
        roll, pitch, yaw = (self.found[f"body.{body}.{a}"] for a in ("phi", "theta", "psi"))
        return pin.rpy.rpyToMatrix(roll, pitch, yaw)

    def omega(self, body: str) -> Matrix:
        if body == "ground":
            return np.zeros(3)
        parts = ("omega_x", "omega", "omega_z")
        return np.array([self.found[f"body.{body}.{part}"] for part in parts])

    def _add(self, link: Any) -> None:
        joint, kind, name = link.joint, link.joint.type, link.joint_name
        parent, place = (0, pin.SE3.Identity()) if link.parent < 0 else self.holders[link.parent]
        unit: dict[str, Any] = dict.fromkeys(("axis", "direction", "second_axis"))
        for key in unit:
            if getattr(joint, key) is not None:
                given = self.vector(joint, key)
                unit[key] = given / np.linalg.norm(given)
        axis, second, along = unit["axis"], unit["second_axis"], unit["direction"]
        across = np.cross(axis, along) if kind == "planar" else None
        slides = {"prismatic": [along], "cylindrical": [axis], "planar": [along, across]}
        turns = {
            "revolute": [axis], "cylindrical": [axis], "planar": [axis], "universal": [axis, second]
        }  # fmt: skip
        at = place * pin.SE3(np.eye(3), self.vector(joint, "parent_to_joint"))
        states = [self.found[f"joint.{name}.{n}"] for n in link.joint_type.positions] if (
            kind not in ("floating",)
        ) else []  # fmt: skip
        rates = [self.found[f"joint.{name}.{n}"] for n in link.joint_type.velocities] if (
            kind not in ("floating",)
        ) else []  # fmt: skip
        if kind == "floating":
            parent = self._free(link.body)
            at = pin.SE3.Identity()
        elif kind == "spherical":
            parent = self.peer.addJoint(parent, pin.JointModelSpherical(), at, name)
            R = self.rotation(joint.parent).T @ self.rotation(link.body)
            self.q += list(pin.Quaternion(R).coeffs())
            turning = self.omega(link.body) - self.omega(joint.parent)
            self.v += list(self.rotation(link.body).T @ turning)
            at = pin.SE3.Identity()
        else:
            steps = [(pin.JointModelPrismaticUnaligned, a) for a in slides.get(kind, [])]
            steps += [(pin.JointModelRevoluteUnaligned, a) for a in turns.get(kind, [])]
            for k, (type_, direction) in enumerate(steps):
                parent = self.peer.addJoint(parent, type_(direction), at, f"{name}{k}")
                at = pin.SE3.Identity()
            self.q += states
            self.v += rates
        child = at * pin.SE3(np.eye(3), self.vector(joint, "joint_to_child"))
        body = self.model.bodies[link.body]
        xx, yy, zz, xy, yz, zx = [*map(self.number, body.inertia), 0, 0, 0][:6]  # pyrefly: ignore[bad-argument-type]
        inertia = np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]], float)
        mass = pin.Inertia(self.number(body.mass), np.zeros(3), inertia)
        self.peer.appendBodyToJoint(parent, mass, child)
        self.holders.append((parent, child))

    def _free(self, body: str) -> int:
        joint = self.peer.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), body)
        R = self.rotation(body)
        self.q += [self.found[f"body.{body}.{a}"] for a in "xyz"]
        self.q += list(pin.Quaternion(R).coeffs())
        self.v += list(R.T @ [self.found[f"body.{body}.v{a}"] for a in "xyz"])
        self.v += list(R.T @ self.omega(body))
        return joint

    def accelerations(self, values: Mapping[str, float]) -> list[float]:
        """(a, α) of every body, CG, world axes."""
        data, q, v = self.peer.createData(), np.array(self.q), np.array(self.v)
        forces = [pin.Force.Zero() for _ in range(self.peer.njoints)]
        pin.forwardKinematics(self.peer, data, q, v)
        tau = np.zeros(self.peer.nv)
        for link, (joint, child) in zip(self.tree.links, self.holders, strict=True):
            body, R = f"body.{link.body}", data.oMi[joint].rotation @ child.rotation
            force = R.T @ [values[f"{body}.force_{a}"] for a in "xyz"]
            moment = R.T @ [values[f"{body}.moment_{a}"] for a in "xyz"]
            forces[joint] += child.act(pin.Force(force, moment))
            efforts = [values[f"joint.{link.joint_name}.{n}"] for n in link.joint_type.efforts]
            if efforts:  # those of the last joints of the chain
                last = self.peer.joints[joint].idx_v
                tau[last + 1 - len(efforts) : last + 1] = efforts
        a = pin.aba(self.peer, data, q, v, tau, forces)
        pin.forwardKinematics(self.peer, data, q, v, a)
        found: list[float] = []
        for joint, child in self.holders:
            R = data.oMi[joint].rotation
            motion, rate = child.actInv(data.a[joint]), child.actInv(data.v[joint])
            linear = motion.linear + np.cross(rate.angular, rate.linear)
            S = R @ child.rotation
            found += [*(S @ linear), *(S @ motion.angular)]
        return found


def error(seed: int, algorithm: type[Recursion] | type[ClosedForm]) -> float:
    """Largest difference of the accelerations of tree `seed`, by the largest acceleration."""
    model = spatial_tree(1000 + seed, size=1 + seed % 12, loads=False)
    tree, r = topology(model), random.Random(seed)
    program = recorded(model, tree, algorithm)
    names = [v.name for v in (*program.inputs, *program.states) if not v.name.startswith("point")]
    values = {name: r.uniform(-1, 1) for name in names}
    outputs = Evaluated(program).outputs(values)
    expected = Peer(model, tree, {**values, **outputs}).accelerations(values)
    found = [outputs[f"body.{link.body}.{part}"] for link in tree.links for part in PARTS]
    return float(np.abs(np.subtract(found, expected)).max() / np.abs(expected).max())


def main() -> None:
    """All trees; exit code 1 if one is beyond the limit."""
    for algorithm in (Recursion, ClosedForm):
        errors = [error(seed, algorithm) for seed in range(TREES)]
        worst = int(np.argmax(errors))
        print(
            f"{algorithm.__name__}: {TREES} trees beside Pinocchio {pin.__version__}: median "
            f"{np.median(errors):.1e}, largest {max(errors):.1e} (tree {worst})"
        )
        if max(errors) > LIMIT:
            raise SystemExit(1)


if __name__ == "__main__":
    main()
