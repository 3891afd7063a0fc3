"""Random planar trees, and their accelerations from positions alone, to any number of digits.

The reference knows how bodies are placed and nothing else: velocities, the velocity transformation
and its rate are difference quotients in mpmath, forces act by virtual work, and
Bᵀ(𝓜 + A)B u̇ = Q − Bᵀ(𝓜 + A)Ḃu is solved by LU decomposition.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mpmath
from support.planar_loads import TABLES, displacement, random_loads, work

from m4e_fmi.model import Body, Joint, Model, Parameter, Point
from m4e_fmi.multibody import Topology, topology

STEP = mpmath.mpf(10) ** -28
"""Of the difference quotients. They are off by STEP² ≈ 1e-56 and need 3·28 digits more."""
DIGITS = 140


class Numbers:
    """Random numbers as parameters of a model, so that nothing is folded in double precision."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.parameters: dict[str, Parameter] = {}

    def between(self, low: float, high: float) -> str:
        name = f"number{len(self.parameters)}"
        self.parameters[name] = Parameter(self.random.uniform(low, high), "1")
        return name

    def pair(self) -> tuple[str, str]:
        return (self.between(-1, 1), self.between(-1, 1))


def random_tree(seed: int, *, size: int, wet: int = 0) -> Model:
    """A tree of `size` bodies with all joints and loads, `wet` of them with added mass."""
    numbers = Numbers(seed)
    r, pair, between = numbers.random, numbers.pair, numbers.between
    bodies: dict[str, Body] = {}
    joints: dict[str, Joint] = {}
    floating = set(r.sample(range(size), k=r.randint(0, max(1, size // 4))))
    wet_bodies = set(r.sample(range(size), k=wet))
    for k in range(size):
        name = f"b{k}"
        parent = r.choice(["ground", *bodies, *list(bodies)[-3:]])
        bodies[name] = Body(between(0.5, 2), between(0.5, 2), added_mass=k in wet_bodies)
        kind: Any = r.choice(["revolute", "revolute", "prismatic", *["fixed"] * (k > 0)])
        coordinate: Any = r.choice(["absolute", "relative"]) if kind == "revolute" else "absolute"
        if k in floating:
            joints[f"j{k}"] = Joint("floating", name)
            continue
        direction = pair() if kind == "prismatic" else None
        joints[f"j{k}"] = Joint(kind, name, parent, pair(), pair(), direction, coordinate)
    points = {f"p{k}": Point(r.choice([*bodies, "ground"]), pair()) for k in range(4)}
    # far away, so that the distance of two points is never close to zero
    points["anchor"] = Point("ground", (30.0, 40.0))
    return Model(
        name=f"tree{seed}",
        bodies=bodies,
        joints=joints,
        points=points,
        loads=random_loads(numbers, joints),
        tables=TABLES,
        parameters=numbers.parameters,
        gravity=between(9, 10),
    )


class Reference:
    """A model in a state given by a program's variable names; numbers are mpmath's."""

    def __init__(self, model: Model, values: Mapping[str, Any]) -> None:
        self.model = model
        self.tree: Topology = topology(model)
        self.given = values
        bodies = [model.bodies[link.body] for link in self.tree.links]
        self.wet = [k for k, body in enumerate(bodies) if body.added_mass]
        self.q = [mpmath.mpf(values[name]) for name in self._names(("x", "z", "theta"), "q")]
        self.t = self.value("time")
        self.parameters = {
            name: mpmath.mpf(values.get(name, p.value)) for name, p in model.parameters.items()
        }
        # by the identity of numbers, which are kept: their hashes would take a fifth of all time
        self._known_steps: dict[tuple[int, ...], tuple[list[Any], list[list[Any]]]] = {}
        self._known_poses: dict[tuple[int, ...], tuple[list[Any], list[tuple[Any, Any, Any]]]] = {}
        self.u = [mpmath.mpf(values[name]) for name in self._names(("vx", "vz", "omega"), "u")]

    def _names(self, floating: tuple[str, ...], other: str) -> list[str]:
        names = []
        for link in self.tree.links:
            if link.joint.type == "floating":
                names += [f"body.{link.body}.{suffix}" for suffix in floating]
            elif link.joint.type != "fixed":
                names.append(f"joint.{link.joint_name}.{other}")
        return names

    def value(self, name: str) -> Any:
        return mpmath.mpf(self.given.get(name, 0.0))

    def number(self, quantity: Any) -> Any:
        """A number of the model: a parameter's name or the number itself."""
        named = self.parameters.get(quantity)
        return mpmath.mpf(quantity) if named is None else named

    def placed(self, pose: Sequence[Any], at: Any) -> tuple[Any, Any]:
        """World position of the point `at` in the axes of a body: R = [[c, s], [−s, c]]."""
        (x, z, theta), (right, up) = pose, map(self.number, at)
        c, s = mpmath.cos(theta), mpmath.sin(theta)
        return x + c * right + s * up, z - s * right + c * up

    def poses(self, q: list[Any]) -> list[tuple[Any, Any, Any]]:
        """(x, z, θ) of every link. The same few q are asked for again and again."""
        key = tuple(map(id, q))
        if key not in self._known_poses:
            self._known_poses[key] = [*q], self._poses(q)
        return self._known_poses[key][1]

    def _poses(self, q: list[Any]) -> list[tuple[Any, Any, Any]]:
        result: list[tuple[Any, Any, Any]] = []
        for link in self.tree.links:
            joint = link.joint
            own = [q[k] for k in link.coordinates]
            if joint.type == "floating":
                result.append((own[0], own[1], own[2]))
                continue
            pose = result[link.parent] if link.parent >= 0 else (mpmath.mpf(0),) * 3
            hold = self.placed(pose, joint.parent_to_joint)
            if joint.type == "fixed":
                pose = (*hold, pose[2])
            elif joint.type == "revolute":
                pose = (*hold, own[0] + (pose[2] if joint.coordinate == "relative" else 0))
            else:
                dx, dz = map(self.number, joint.direction or ())
                far = own[0] / mpmath.sqrt(dx * dx + dz * dz)
                pose = (*self.placed((*hold, pose[2]), (far * dx, far * dz)), pose[2])
            result.append((*self.placed(pose, joint.joint_to_child), pose[2]))
        return result

    def pose(self, body: str, q: list[Any]) -> tuple[Any, Any, Any]:
        k = self.tree.index(body)
        return self.poses(q)[k] if k >= 0 else (mpmath.mpf(0),) * 3

    def point(self, name: str, q: list[Any]) -> tuple[Any, Any]:
        point = self.model.points[name]
        return self.placed(self.pose(point.body, q), point.at)

    def moved(self, side: int, along: list[Any]) -> list[Any]:
        """The coordinates after a step; those that stay are the same objects."""
        pairs = zip(self.q, along, strict=True)
        return [q + side * STEP * d if d else q for q, d in pairs]

    def slope(self, function: Callable[[list[Any]], Any], along: list[Any]) -> Any:
        """Derivative of a scalar function of q along a direction."""
        key = tuple(map(id, along))
        if key not in self._known_steps:
            self._known_steps[key] = [*along], [self.moved(side, along) for side in (1, -1)]
        ahead, behind = map(function, self._known_steps[key][1])
        return (ahead - behind) / (2 * STEP)

    def accelerations(self) -> list[Any]:
        """u̇."""
        n, bodies = len(self.q), len(self.tree.links)
        units = [[mpmath.mpf(i == j) for i in range(n)] for j in range(n)]
        B = mpmath.matrix(3 * bodies, n)
        bias = mpmath.matrix(3 * bodies, 1)
        steps = [self.moved(side, self.u) for side in (1, -1)]
        for row in range(3 * bodies):

            def part(q: list[Any], row: int = row) -> Any:
                return self.poses(q)[row // 3][row % 3]

            for j, unit in enumerate(units):
                B[row, j] = self.slope(part, unit)
            ahead, behind = steps
            bias[row] = (part(ahead) - 2 * part(self.q) + part(behind)) / STEP**2
        weighted = B.T * self._inertia()
        forces = mpmath.matrix([self._work(unit) for unit in units])
        return list(mpmath.lu_solve(weighted * B, forces - weighted * bias))

    def _inertia(self) -> Any:
        links = self.tree.links
        result = mpmath.matrix(3 * len(links), 3 * len(links))
        for k, link in enumerate(links):
            body = self.model.bodies[link.body]
            for axis, entry in enumerate((body.mass, body.mass, body.inertia)):
                result[3 * k + axis, 3 * k + axis] = self.number(entry)
        rows = [3 * k + axis for k in self.wet for axis in range(3)]
        for i, row in enumerate(rows, start=1):
            for j, column in enumerate(rows, start=1):
                result[row, column] += self.value(f"added_mass[{i},{j}]")
        return result

    def _work(self, unit: list[Any]) -> Any:
        """Work of all forces along a unit change of one coordinate."""
        total = self.input_work(unit)
        for body in self.model.bodies:
            weight = self.number(self.model.bodies[body].mass) * self.number(self.model.gravity)
            total -= weight * self.slope(lambda q, b=body: self.pose(b, q)[1], unit)
        return total + sum(work(self, load, unit) for load in self.model.loads.values())

    def input_work(self, along: list[Any]) -> Any:
        """Work of the inputs along a change of the coordinates; along u, their power."""
        total = mpmath.mpf(0)
        for link in self.tree.links:
            body = link.body
            for axis, name in enumerate(("force_x", "force_z", "moment_y")):
                rise = self.slope(lambda q, b=body, a=axis: self.pose(b, q)[a], along)
                total += self.value(f"body.{body}.{name}") * rise
            if link.joint.type in ("revolute", "prismatic"):
                effort = self.value(f"joint.{link.joint_name}.effort")
                total += effort * self.slope(displacement(self, link.joint_name), along)
        for name in self.model.points:
            for axis, force in enumerate(("force_x", "force_z")):
                rise = self.slope(lambda q, n=name, a=axis: self.point(n, q)[a], along)
                total += self.value(f"point.{name}.{force}") * rise
        return total
