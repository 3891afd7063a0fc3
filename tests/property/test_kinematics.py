"""Random trees: B, Ḃ, the mass matrix, Eq. (5) and the balance of energy.

The reference for B and Ḃ is a forward kinematics written here, over numbers that carry exact first
and second derivatives: complex numbers with an infinitesimal imaginary part, inside dual numbers.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support.programs import Evaluated

from m4e_fmi.joints import JOINT_TYPES
from m4e_fmi.model import (
    Body,
    Joint,
    Model,
    Point,
    TensionDamper,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.multibody import Topology, closed_form, model_program, topology
from m4e_fmi.multibody.assembly import Assembly, Scalars, assemble
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.model_program.recording import recorded
from m4e_fmi.multibody.sensitivity import Recursion
from m4e_fmi.multibody.velocity_transformation import column_rates, columns
from m4e_fmi.space import PLANE, X, Z

GRAVITY = 9.81
INFINITESIMAL = 1e-100  # its square vanishes: derivatives are exact to rounding


@dataclass(frozen=True)
class Dual:
    """a + εb with ε² = 0, over complex numbers."""

    a: complex
    b: complex = 0.0

    def __add__(self, other: Dual) -> Dual:
        return Dual(self.a + other.a, self.b + other.b)

    def __mul__(self, other: Dual) -> Dual:
        return Dual(self.a * other.a, self.a * other.b + self.b * other.a)

    def __neg__(self) -> Dual:
        return Dual(-self.a, -self.b)


def turned(angle: Dual, vector: tuple[float, float]) -> tuple[Dual, Dual]:
    """R(θ) times a vector of the body."""
    c = Dual(cmath.cos(angle.a), -cmath.sin(angle.a) * angle.b)
    s = Dual(cmath.sin(angle.a), cmath.cos(angle.a) * angle.b)
    x, z = Dual(vector[0]), Dual(vector[1])
    return c * x + s * z, -(s * x) + c * z


@dataclass(frozen=True)
class Case:
    """A random model, its state and what acts on it from outside."""

    model: Model
    q: np.ndarray
    u: np.ndarray
    inputs: dict[str, float]
    added_mass: np.ndarray

    @property
    def tree(self) -> Topology:
        return topology(self.model)

    def place(self, q: list[Dual]) -> list[Dual]:
        """(x, z, θ) of every body, in the order of the links, for coordinates `q`."""
        places: dict[str, tuple[Dual, Dual, Dual]] = {"ground": (Dual(0), Dual(0), Dual(0))}
        result: list[Dual] = []
        remaining = list(q)
        for link in self.tree.links:
            own = [remaining.pop(0) for _ in link.coordinates]
            joint = link.joint
            x, z, theta = places[joint.parent]
            outer, inner = _floats(joint.parent_to_joint), _floats(joint.joint_to_child)
            if joint.type == "floating":
                x, z, theta = own
            elif joint.type == "revolute":
                angle = own[0] + theta if joint.coordinate == "relative" else own[0]
                steps = (turned(theta, outer), turned(angle, inner))
                x, z, theta = _moved(x, steps, 0), _moved(z, steps, 1), angle
            elif joint.type == "fixed":
                steps = (turned(theta, outer), turned(theta, inner))
                x, z = _moved(x, steps, 0), _moved(z, steps, 1)
            else:
                assert joint.direction is not None
                direction = np.array(_floats(joint.direction))
                dx, dz = turned(theta, tuple(direction / np.linalg.norm(direction)))
                slid = (own[0] * dx, own[0] * dz)
                steps = (turned(theta, outer), turned(theta, inner), slid)
                x, z = _moved(x, steps, 0), _moved(z, steps, 1)
            places[link.body] = (x, z, theta)
            result += places[link.body]
        return result

    def jacobians(self) -> tuple[np.ndarray, np.ndarray]:
        """B = ∂(x, z, θ)/∂q and Ḃ = Σ ∂B/∂q_k u_k."""
        n = len(self.q)
        B, B_dot = np.zeros((3 * len(self.tree.links), n)), np.zeros((3 * len(self.tree.links), n))
        for j in range(n):
            step = [complex(0, INFINITESIMAL if j == k else 0) for k in range(n)]
            q = [Dual(a + h, b) for a, h, b in zip(self.q, step, self.u, strict=True)]
            column = self.place(q)
            B[:, j] = [p.a.imag / INFINITESIMAL for p in column]
            B_dot[:, j] = [complex(p.b).imag / INFINITESIMAL for p in column]
        return B, B_dot

    def assembled(self) -> Assembly:
        """The model in motion, over floats and without inputs."""
        return assemble(
            self.model,
            self.tree,
            Scalars(
                q=self.q.tolist(),
                u=self.u.tolist(),
                time=0.0,
                parameters={},
                body_wrench={},
                point_force={},
                effort={},
                added_mass=self.added_mass.tolist(),
            ),
        )

    def values(self) -> dict[str, float]:
        """State, inputs and added mass by the names of the program."""
        names = [v.name for v in _program(self).program.states]
        state = dict(zip(names, np.column_stack([self.q, self.u]).ravel(), strict=True))
        n = len(self.added_mass)
        added = {
            f"added_mass[{i + 1},{j + 1}]": self.added_mass[i, j]
            for i in range(n)
            for j in range(n)
        }
        return {**state, **self.inputs, **added}


def number(quantity: Any) -> float:
    """A quantity that this test has given as a number."""
    return float(quantity)


def _floats(pair: Any) -> tuple[float, float]:
    return float(pair[0]), float(pair[1])


def _moved(start: Dual, steps: tuple[tuple[Dual, Dual], ...], axis: int) -> Dual:
    for step in steps:
        start = start + step[axis]
    return start


def _program(case: Case) -> Evaluated:
    return Evaluated(model_program(case.model))


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Two decimals: small examples stay readable."""
    return st.integers(round(100 * low), round(100 * high)).map(lambda k: k / 100)


@st.composite
def cases(draw: st.DrawFn) -> Case:
    count = draw(st.integers(1, 12))
    names = [f"b{k}" for k in range(count)]
    joints, bodies = {}, {}
    arm = st.tuples(numbers(-2, 2), numbers(-2, 2))
    for k, name in enumerate(names):
        kind = draw(st.sampled_from(list(JOINT_TYPES[2])))
        parent = "ground"
        fields: dict[str, Any] = {}
        if kind != "floating":
            parent = draw(st.sampled_from(["ground", *names[:k]]))
            fields = {"parent_to_joint": draw(arm), "joint_to_child": draw(arm)}
        if kind == "prismatic":
            fields["direction"] = draw(arm.filter(lambda d: abs(d[0]) + abs(d[1]) > 0.1))
        if kind == "revolute":
            fields["coordinate"] = draw(st.sampled_from(["absolute", "relative"]))
        joints[f"j{k}"] = Joint(kind, name, parent, **fields)
        wet = draw(st.booleans())
        bodies[name] = Body(draw(numbers(0.5, 5)), draw(numbers(0.1, 5)), added_mass=wet)
    assume(any(joint.type != "fixed" for joint in joints.values()))
    points = {name: Point(draw(st.sampled_from([*names, "ground"])), draw(arm)) for name in "ABC"}
    model = Model(
        name="random",
        gravity=GRAVITY,
        bodies={name: bodies[name] for name in draw(st.permutations(names))},
        joints=joints,
        points=points,
        loads=draw(_loads(names)),
    )
    n = len(topology(model).coordinate_names)
    wet = 3 * sum(body.added_mass for body in bodies.values())
    # unstructured numbers, from a seed: drawing a hundred of them one by one would be slow
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    root = rng.uniform(-1, 1, (wet, wet))
    inputs = [v.name for v in model_program(model).inputs]
    case = Case(
        model,
        q=rng.uniform(-2, 2, n),
        u=rng.uniform(-2, 2, n),
        inputs=dict(zip(inputs, rng.uniform(-10, 10, len(inputs)), strict=True)),
        added_mass=root @ root.T,
    )
    unloaded = replace(case, model=replace(model, loads={})).assembled()
    places = [np.array(unloaded.points[name].position, float) for name in "AB"]
    assume(np.linalg.norm(places[0] - places[1]) > 0.1)  # the line between them has a direction
    return case


@st.composite
def _loads(draw: st.DrawFn, names: list[str]) -> dict[str, Any]:
    bodies = draw(st.permutations([*names, "ground"]))[:2]
    ends = (bodies[0], bodies[1])
    loads: dict[str, Any] = {
        "spring": TensionSpring(("A", "B"), draw(numbers(0, 50)), draw(numbers(0, 3))),
        "damper": TensionDamper(("A", "B"), draw(numbers(0, 5))),
        "twist": TorsionSpring(ends, draw(numbers(0, 50)), draw(numbers(-1, 1))),
        "rub": TorsionDamper(ends, draw(numbers(0, 5))),
    }
    kept = draw(st.sets(st.sampled_from(sorted(loads))))
    return {name: loads[name] for name in sorted(kept)}


def over_random_trees(count: int) -> Callable[[Callable[[Case], None]], Callable[[], None]]:
    def drawn(test: Callable[[Case], None]) -> Callable[[], None]:
        return settings(max_examples=count, deadline=None, derandomize=True)(given(cases())(test))

    return drawn


def scale(*values: Any) -> float:
    return max(1.0, *(float(np.abs(value).max(initial=0.0)) for value in values))


@pytest.mark.verifies(
    "B and Ḃ of 200 trees with up to 12 bodies",
    independent="forward kinematics in numbers with exact derivatives",
    tolerance="1e-12",
)
@pytest.mark.verifies(
    "their accelerations", published="Sabet and Diaz-Flores Caminero, Eq. (5)", tolerance="1e-10"
)
@over_random_trees(200)
def test_accelerations_are_those_of_equation_5(case: Case) -> None:
    """B and Ḃ are right, M = Bᵀ(𝓜 + A)B is symmetric positive definite, and M u̇ = f."""
    B, B_dot = case.jacobians()
    assembly = case.assembled()
    tree, frames = assembly.tree, assembly.frames
    for k in range(len(frames)):
        for expected, found in (
            (B, columns(tree, frames, k)),
            (B_dot, column_rates(tree, frames, assembly.u, k)),
        ):
            got = np.zeros((3, len(case.q)))
            for j, column in found.items():
                got[:, j] = [column[c] for c in PLANE]
            # sums of at most 25 products of numbers up to 2 · 24
            assert got == pytest.approx(expected[3 * k : 3 * k + 3], rel=0, abs=1e-12)

    inertia = _inertia(case)
    mass_matrix = B.T @ inertia @ B
    composed = np.zeros_like(mass_matrix)
    for i, row in enumerate(closed_form.mass_matrix(assembly)):
        for j, entry in row.items():
            composed[i, j] = entry
    assert composed == pytest.approx(mass_matrix, rel=0, abs=1e-12 * scale(mass_matrix))
    assert np.linalg.eigvalsh(mass_matrix).min() > 0

    forcing = B.T @ (_Wrench(case, B).total - inertia @ B_dot @ case.u) + _efforts(case)
    expected = np.linalg.solve(mass_matrix, forcing)
    for algorithm in _algorithms(case):
        program = Evaluated(recorded(case.model, tree, algorithm))
        rates = list(program.rates(case.values()).values())
        assert rates[0::2] == list(case.u)
        # factorisations in double precision; condition numbers stay below 1e4
        assert rates[1::2] == pytest.approx(expected, rel=0, abs=1e-10 * scale(expected))


def _algorithms(case: Case) -> list[type[ClosedForm] | type[Recursion]]:
    """Both, except that the recursion does not know added mass between bodies."""
    return [ClosedForm] if len(case.added_mass) > 3 else [ClosedForm, Recursion]


@over_random_trees(60)
def test_outputs_are_the_derivatives_they_say_and_energy_is_balanced(case: Case) -> None:
    """Central differences along the motion: d/dt of position, velocity and energy."""
    program = _program(case)
    values = case.values()
    rates = program.rates(values)
    h = 1e-5
    ahead, behind = (
        program.outputs(
            {**values, **{name: values[name] + sign * h * rates[name] for name in rates}}
        )
        for sign in (1, -1)
    )
    now = program.outputs(values)
    slopes = {name: (ahead[name] - behind[name]) / (2 * h) for name in now} | rates
    # error of the difference: h² times a third derivative, plus rounding over h: 1e-10 each
    allowed = 1e-9 * scale(list(now.values()), list(rates.values())) ** 2
    pairs = {
        v.name: v.derivative_of
        for v in (*program.program.outputs, *program.program.states)
        if v.derivative_of
    }
    assert len(pairs) >= len(case.model.bodies)
    for name, base in pairs.items():
        value = now[name] if name in now else values[name]
        assert value == pytest.approx(slopes[base], rel=0, abs=allowed), f"{name} = d {base}/dt"

    assert now["energy.total"] == now["energy.kinetic"] + now["energy.potential"]
    power = _power(case, {**values, **now})
    assert slopes["energy.total"] == pytest.approx(power, rel=0, abs=allowed)


def _inertia(case: Case) -> np.ndarray:
    """𝓜 + A."""
    links = case.tree.links
    masses = [case.model.bodies[link.body] for link in links]
    diagonal = [value for body in masses for value in (body.mass, body.mass, body.inertia)]
    total = np.diag(np.array(diagonal, float))
    rows = [3 * k + a for k, body in enumerate(masses) if body.added_mass for a in range(3)]
    total[np.ix_(rows, rows)] += case.added_mass
    return total


class _Wrench:
    """Sum of what acts on the CGs: gravity, inputs, springs and dampers; `total` in B's rows."""

    def __init__(self, case: Case, B: np.ndarray) -> None:
        self.case = case
        self.velocity = B @ case.u
        self.frames = case.assembled().frames
        self.index = {link.body: k for k, link in enumerate(case.tree.links)}
        self.total = np.zeros(len(B))
        for body, k in self.index.items():
            self.total[3 * k + 1] -= number(case.model.bodies[body].mass) * GRAVITY
            for a, part in enumerate(("force_x", "force_z", "moment_y")):
                self.total[3 * k + a] += case.inputs[f"body.{body}.{part}"]
        for name, point in case.model.points.items():
            if point.body in self.index:
                self.push(name, np.array([case.inputs[f"point.{name}.force_{a}"] for a in "xz"]))
        for load in case.model.loads.values():
            if isinstance(load, TensionSpring | TensionDamper):
                self.pull(load)
            elif isinstance(load, TorsionSpring | TorsionDamper):
                self.twist(load)

    def motion(self, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Arm from the CG, position and velocity of a point."""
        point = self.case.model.points[name]
        k = self.index.get(point.body)
        if k is None:
            return np.zeros(2), np.array(_floats(point.at)), np.zeros(2)
        x, z = turned(Dual(self.frames[k].angle), _floats(point.at))
        arm = np.array([complex(x.a).real, complex(z.a).real])
        spin = self.velocity[3 * k + 2] * np.array([arm[1], -arm[0]])
        position = np.array(self.frames[k].position, float)[[X, Z]] + arm
        return arm, position, self.velocity[3 * k : 3 * k + 2] + spin

    def push(self, name: str, force: np.ndarray) -> None:
        k = self.index.get(self.case.model.points[name].body)
        if k is not None:
            arm, _, _ = self.motion(name)
            self.total[3 * k : 3 * k + 2] += force
            self.total[3 * k + 2] += arm[1] * force[0] - arm[0] * force[1]

    def pull(self, load: TensionSpring | TensionDamper) -> None:
        (_, a, va), (_, b, vb) = (self.motion(name) for name in load.points)
        length = np.linalg.norm(b - a)
        along = (b - a) / length
        if isinstance(load, TensionSpring):
            tension = number(load.stiffness) * (length - number(load.length))
        else:
            tension = number(load.damping) * ((vb - va) @ along)
        self.push(load.points[0], tension * along)
        self.push(load.points[1], -tension * along)

    def twist(self, load: TorsionSpring | TorsionDamper) -> None:
        ends = [self.index.get(name) for name in load.bodies]
        angles = [0.0 if k is None else float(self.frames[k].angle) for k in ends]
        speeds = [0.0 if k is None else self.velocity[3 * k + 2] for k in ends]
        if isinstance(load, TorsionSpring):
            torque = number(load.stiffness) * (angles[1] - angles[0] - number(load.angle))
        else:
            torque = number(load.damping) * (speeds[1] - speeds[0])
        for k, part in zip(ends, (torque, -torque), strict=True):
            if k is not None:
                self.total[3 * k + 2] += part


def _efforts(case: Case) -> np.ndarray:
    """τ: on the child's coordinate and, for an absolute angle, back on what turns the parent."""
    total = np.zeros(len(case.q))
    for link in case.tree.links:
        if link.joint.type in ("floating", "fixed"):
            continue
        effort = case.inputs[f"joint.{link.joint_name}.effort"]
        total[link.coordinates[0]] += effort
        absolute = link.joint.coordinate == "absolute"
        if link.joint.type == "revolute" and absolute and link.parent >= 0:
            for back in case.tree.links[link.parent].angles:
                total[back] -= effort
    return total


def _power(case: Case, values: dict[str, float]) -> float:
    """Power of the inputs and of the dampers [W], from the velocities that the model reports."""
    links = case.tree.links
    omega = {link.body: values[f"body.{link.body}.omega"] for link in links} | {"ground": 0.0}
    speeds: dict[str, float] = {}
    for link in links:
        speeds[f"body.{link.body}.force_x"] = values[f"body.{link.body}.vx"]
        speeds[f"body.{link.body}.force_z"] = values[f"body.{link.body}.vz"]
        speeds[f"body.{link.body}.moment_y"] = omega[link.body]
        joint = f"joint.{link.joint_name}"
        if link.joint.type == "revolute":
            speeds[f"{joint}.effort"] = omega[link.body] - omega[link.joint.parent]
        elif link.joint.type == "prismatic":
            speeds[f"{joint}.effort"] = values[f"{joint}.u"]
    for name, point in case.model.points.items():
        if point.body != "ground":
            for axis in "xz":
                speeds[f"point.{name}.force_{axis}"] = values[f"point.{name}.v{axis}"]
    assert set(speeds) == set(case.inputs)
    power = sum(case.inputs[name] * speed for name, speed in speeds.items())
    for load in case.model.loads.values():
        if isinstance(load, TorsionDamper):
            power -= number(load.damping) * (omega[load.bodies[1]] - omega[load.bodies[0]]) ** 2
        elif isinstance(load, TensionDamper):
            power -= number(load.damping) * _lengthening(case, load, values) ** 2
    return power


def _lengthening(case: Case, load: TensionDamper, values: dict[str, float]) -> float:
    """Speed at which the points of a damper part [m/s]."""
    line, rate = np.zeros(2), np.zeros(2)
    for sign, name in zip((-1, 1), load.points, strict=True):
        point = case.model.points[name]
        if point.body == "ground":
            line += sign * np.array(_floats(point.at))
        else:
            line += sign * np.array([values[f"point.{name}.{axis}"] for axis in "xz"])
            rate += sign * np.array([values[f"point.{name}.v{axis}"] for axis in "xz"])
    return float(rate @ line / np.linalg.norm(line))
