"""What runs against what is read: recursion and closed form solve the paper's Eq. (5)."""

from __future__ import annotations

import random
from typing import Any

import mpmath
import pytest
import sympy as sp
from support.programs import Evaluated
from support.tape_values import exact_values

from m4e_fmi.model import Body, Joint, Model, Parameter
from m4e_fmi.multibody import Equations, model_program, topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.sensitivity import Recursion
from m4e_fmi.program import Program
from m4e_fmi.program.symbolic_form import to_sympy

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


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("name", list(MECHANISMS)[:3])
def test_what_runs_solves_them(name: str, algorithm: str) -> None:
    """M u̇ − f = 0 as an identity in q, u and the parameters."""
    e = Equations(mechanism(name))
    form = to_sympy(recorded(e.model, topology(e.model), ALGORITHMS[algorithm]))
    same = {form.symbols[n]: sp.Symbol(n, real=True) for n in PARAMETERS if n in form.symbols}
    same |= {symbol: 0 for n, symbol in form.symbols.items() if "force" in n or "moment" in n}
    same |= {symbol: 0 for n, symbol in form.symbols.items() if "effort" in n}
    states = [v.name for v in recorded(e.model, topology(e.model), ALGORITHMS[algorithm]).states]
    coordinates = zip(states[::2], states[1::2], e.q.flat(), e.u.flat(), strict=True)
    for position, velocity, q, u in coordinates:
        for name_of_state, symbol in ((position, q), (velocity, u)):
            if name_of_state in form.symbols:
                same[form.symbols[name_of_state]] = symbol
    rates = sp.Matrix([sp.nsimplify(r.subs(same)) for r in form.rates[1::2]])
    assert all(is_zero(entry) for entry in e.mass_matrix * rates - e.forcing)


def pendulum(n: int) -> Model:
    """n hinged rods of 2 m and 10 kg."""
    joints = {}
    for k in range(n):
        at = {"parent": f"link{k - 1}", "parent_to_joint": ("L/2", 0.0)} if k else {}
        joints[f"hinge{k}"] = Joint("revolute", f"link{k}", joint_to_child=("L/2", 0.0), **at)
    bodies = {f"link{k}": Body("m", "m*L**2/12") for k in range(n)}
    parameters = {"m": Parameter(10.0, "kg"), "L": Parameter(2.0, "m")}
    return Model(name="pendulum", bodies=bodies, joints=joints, parameters=parameters, gravity=9.81)


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


def test_the_cost_of_a_chain_grows_with_its_length() -> None:
    """A link more costs the same at every length: 75 operations with all its inputs."""
    counts = [operations(model_program(pendulum(n))) for n in (20, 21, 40, 41)]
    assert counts[1] - counts[0] == counts[3] - counts[2] <= 75


@pytest.mark.parametrize("n", [1, 2, 3, 6, 8])
def test_the_cheaper_algorithm_is_taken(n: int) -> None:
    model = pendulum(n)
    both = [operations(recorded(model, topology(model), a)) for a in ALGORITHMS.values()]
    assert operations(model_program(model)) == min(both)
