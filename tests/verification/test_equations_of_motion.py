"""Programs against printed equations: recursion and closed form solve the paper's Eq. (5)."""

from __future__ import annotations

import random
from typing import Any

import mpmath
import pytest
import sympy as sp
from support.programs import Evaluated
from support.tape_values import exact_values, tape_values

from m4e_fmi.model import Body, Joint, Model, Parameter
from m4e_fmi.multibody import Equations, model_program, topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.recursion import Recursion
from m4e_fmi.program import Program, jacobian, tangent

ALGORITHMS = {"recursion": Recursion, "closed form": ClosedForm}
BODIES = {"one": Body("m", "J"), "two": Body(2, 3), "three": Body(1, 1)}
PARAMETERS = {"m": Parameter(1.0, "kg"), "J": Parameter(1.0, "kg.m2")}
MECHANISMS = {
    "double pendulum": {
        "a": Joint("revolute", "one", joint_to_child=(0, -2)),
        "b": Joint("revolute", "two", "one", (1, -3), (0, -1)),
    },
    "slider in a pendulum": {
        "a": Joint("revolute", "one", joint_to_child=(0, -2)),
        "b": Joint("prismatic", "two", "one", (1, 0), (0, 1), (0, 1)),
    },
    "pendulum on a slide": {
        "a": Joint("prismatic", "one", direction=(1, 0)),
        "b": Joint("revolute", "two", "one", (0, 1), (2, 0)),
    },
    "relative double pendulum": {
        "a": Joint("revolute", "one", joint_to_child=(0, -2)),
        "b": Joint("revolute", "two", "one", (1, -3), (0, -1), coordinate="relative"),
    },
    "weld between hinges": {
        "a": Joint("revolute", "one", joint_to_child=(1, -2)),
        "b": Joint("fixed", "two", "one", (0, 1), (2, 0)),
        "c": Joint("revolute", "three", "two", (1, 0), (1, 2), coordinate="relative"),
    },
    "pendulum on a float": {
        "a": Joint("floating", "one"),
        "b": Joint("revolute", "two", "one", (0, 1), (2, -1)),
    },
    "slide, hinge, hinge": {
        "a": Joint("prismatic", "one", direction=(0, 1)),
        "b": Joint("revolute", "two", "one", (0, 1), (2, 0)),
        "c": Joint("revolute", "three", "two", (1, 0), (1, 0)),
    },
}


def mechanism(name: str) -> Model:
    joints = MECHANISMS[name]
    bodies = {joint.child: BODIES[joint.child] for joint in joints.values()}
    return Model(name="few", bodies=bodies, joints=joints, parameters=PARAMETERS, gravity=10)


def is_zero(expression: Any) -> bool:
    """Exactly, with cos² = 1 − sin², for an expression that is rational in sines and cosines."""
    numerator = sp.numer(sp.together(expression))
    angles = sorted({f.args[0] for f in numerator.atoms(sp.sin, sp.cos)}, key=str)
    circles = []
    for k, angle in enumerate(angles):
        c, s = sp.symbols(f"c{k} s{k}")
        numerator = numerator.subs({sp.cos(angle): c, sp.sin(angle): s})
        circles.append(c**2 + s**2 - 1)
    numerator = sp.expand(numerator)
    if not circles or numerator == 0:
        return numerator == 0
    generators = sorted({g for circle in circles for g in circle.free_symbols}, key=str)
    return sp.reduced(numerator, circles, *generators)[1] == 0


@pytest.mark.verifies(
    "M, f and Ḃ of all joint types, symbolically",
    published="Sabet and Diaz-Flores Caminero, Eqs. (3) to (5)",
    tolerance="identical",
)
@pytest.mark.parametrize("name", MECHANISMS)
def test_mass_matrix_and_forcing_are_those_of_equation_5(name: str) -> None:
    e = Equations(mechanism(name))
    inertias = [p for body in e.topology.links for p in (0, 0, 1)]
    values = [e.model.bodies[link.body] for link in e.topology.links for _ in range(3)]
    fields = [b.inertia if turn else b.mass for b, turn in zip(values, inertias, strict=True)]
    real = [sp.Symbol(f, real=True) if isinstance(f, str) else sp.Integer(f) for f in fields]
    bodies = sp.diag(*real)
    weight = sp.Matrix([-10 * m if k % 3 == 1 else 0 for k, m in enumerate(real)])
    assert all(is_zero(entry) for entry in e.mass_matrix - e.B.T * bodies * e.B)
    forcing = e.B.T * (weight - bodies * e.B_dot * e.u)
    assert all(is_zero(entry) for entry in e.forcing - forcing)
    rates = sum(
        (sp.diff(e.B, q) * u for q, u in zip(e.q.flat(), e.u.flat(), strict=True)),
        sp.zeros(*e.B.shape),
    )
    assert all(is_zero(entry) for entry in e.B_dot - rates)


@pytest.mark.verifies(
    "M q̈ = f of recursion and closed form, symbolically",
    published="Sabet and Diaz-Flores Caminero, Eq. (5)",
    tolerance="identical",
)
@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("name", list(MECHANISMS)[:5])
def test_what_runs_solves_them(name: str, algorithm: str) -> None:
    """M u̇ − f = 0 as an identity in q, u and the parameters."""
    e = Equations(mechanism(name))
    program = recorded(e.model, topology(e.model), ALGORITHMS[algorithm])
    meaning: dict[str, Any] = {v.name: 0 for v in program.inputs}
    meaning |= {p: sp.Symbol(p, real=True) for p in PARAMETERS}
    names = [v.name for v in program.states]
    meaning |= dict(zip(names[::2], e.q.flat(), strict=True))
    meaning |= dict(zip(names[1::2], e.u.flat(), strict=True))
    values = tape_values(program.tape, program.rates, meaning, number=sp.Float, functions=sp)
    rates = sp.Matrix([sp.nsimplify(rate) for rate in values[1::2]])
    assert all(is_zero(entry) for entry in e.mass_matrix * rates - e.forcing)


def pendulum(n: int) -> Model:
    """n hinged rods of 2 m and 10 kg."""
    joints = {}
    for k in range(n):
        at: dict[str, Any] = {}
        if k:
            at = {"parent": f"link{k - 1}", "parent_to_joint": ("L/2", 0.0)}
        joints[f"hinge{k}"] = Joint("revolute", f"link{k}", joint_to_child=("L/2", 0.0), **at)
    bodies = {f"link{k}": Body("m", "m*L**2/12") for k in range(n)}
    parameters = {"m": Parameter(10.0, "kg"), "L": Parameter(2.0, "m")}
    return Model(name="pendulum", bodies=bodies, joints=joints, parameters=parameters, gravity=9.81)


@pytest.mark.verifies(
    "accelerations of 60 links in doubles",
    independent="the recorded operations in mpmath, 50 digits",
    tolerance="1e-14",
)
def test_sixty_links_are_accurate_to_the_last_digits() -> None:
    program = model_program(pendulum(60))
    r = random.Random(1)
    values = {v.name: r.uniform(-3, 3) for v in program.states}
    doubles = list(Evaluated(program).rates(values).values())[1::2]
    with mpmath.workdps(50):
        exact = exact_values(program, program.rates[1::2], values)
        errors = [abs(a - b) for a, b in zip(doubles, exact, strict=True)]
        # about 75 operations per link, each wrong by 1e-16 at most, most of them unfelt far away
        assert max(errors) / max(map(abs, exact)) < 1e-14


def operations(program: Program) -> int:
    return len(program.operations(program.rates))


def test_a_directional_derivative_costs_little_more_than_the_rates() -> None:
    """Rates and their change along all states together: 2.2 times the rates alone."""
    program = model_program(pendulum(60))
    change = tangent(program, [v.name for v in program.states])
    both = len(change.operations([*change.rates, *change.results[: len(program.states)]]))
    assert both < 2.2 * operations(program)


def test_a_jacobian_costs_a_few_operations_for_each_entry() -> None:
    """∂u̇/∂(q, u) is full, 2 n² entries; 16 operations each, the rates included."""
    program = model_program(pendulum(20))
    matrix = jacobian(program, by=[v.name for v in program.states])
    entries = len(matrix.row_indices)
    assert entries == 2 * 20**2 + 20  # and q̇ = u
    assert len(matrix.program.operations(matrix.program.results)) < 16 * entries


def test_the_cost_of_a_chain_grows_with_its_length() -> None:
    """A link more costs the same at every length: 75 operations with all its inputs."""
    counts = [operations(model_program(pendulum(n))) for n in (20, 21, 40, 41)]
    assert counts[1] - counts[0] == counts[3] - counts[2] <= 75


@pytest.mark.parametrize("n", [1, 2, 3, 6, 8])
def test_the_cheaper_algorithm_is_taken(n: int) -> None:
    model = pendulum(n)
    both = [operations(recorded(model, topology(model), a)) for a in ALGORITHMS.values()]
    assert operations(model_program(model)) == min(both)
