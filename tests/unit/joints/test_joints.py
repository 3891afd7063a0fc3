"""The contract of a type of joint: each of the package, and those of `NEW`, files of tests/support.

A new type is tested by its entry in `NEW`, or in `JOINT_TYPES` of the package. Equations of the
package's types beside independent ones: tests/property (trees of all types, 50 digits).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.lagrange import RELATIVE, Mechanism, turned
from support.pin_in_slot import PinInSlot
from support.programs import Evaluated
from support.screw import Screw

from m4e_fmi import build_fmu, read_description
from m4e_fmi.errors import InputError
from m4e_fmi.joints import JOINT_TYPES, JointType
from m4e_fmi.model import Body, Joint, Model, TorsionSpring, load_model
from m4e_fmi.multibody import mass_matrix_program, model_program, topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.recursion import Recursion
from m4e_fmi.program import tangent
from m4e_fmi.report import animate, draw_model
from m4e_fmi.simulate import simulate

PAGE = Path(__file__).parents[3] / "docs" / "model_files.md"
OWN = [(n, name) for n, types in JOINT_TYPES.items() for name in types]
NEW = [(2, Screw()), (2, PinInSlot())]
EVERY = [*OWN, *((n, joint_type.name) for n, joint_type in NEW)]
STEP = 1e-5
"""Of difference quotients [s]: their error is STEP² times third derivatives, of some 1e3."""


@pytest.fixture(autouse=True)
def new_types(monkeypatch: pytest.MonkeyPatch) -> None:
    for dimensions, joint_type in NEW:
        monkeypatch.setitem(JOINT_TYPES[dimensions], joint_type.name, joint_type)


def joint_of(dimensions: int, kind: str) -> JointType:
    return JOINT_TYPES[dimensions][kind]


def machine(dimensions: int, kind: str, **more: Any) -> Model:
    """An arm on a hinge, what moves against it (or against the ground), and a rod on that."""
    joint_type = joint_of(dimensions, kind)
    n: Any = dimensions
    vector = ((0.1, -0.4, 0.2), (0.3, 0.2, -0.1), (0.4, 0.3, 0.0))
    axes = {"axis": (0.0, 0.6, 0.8), "second_axis": (1.0, 0.5, 0.0)}
    inertia: Any = 0.4 if n == 2 else (0.4, 0.5, 0.6)
    place: dict[str, Any] = {
        "parent": "arm",
        "parent_to_joint": vector[0][:n],
        "joint_to_child": vector[1][:n],
        **({"direction": vector[2][:n]} if joint_type.has_direction else {}),
        **{name: axes[name] for name in joint_type.axes},
    }
    if kind == "planar":
        place["direction"] = (1.0, 0.0, 0.0)
    hinge: dict[str, Any] = {"axis": (0.0, 1.0, 0.0)} if n == 3 else {}
    down = (0.0, -0.5) if n == 2 else (0.0, 0.3, -0.5)
    return Model(
        "machine",
        {name: Body(mass, inertia) for name, mass in (("arm", 3.0), ("nut", 2.0), ("rod", 1.0))},
        {
            "shoulder": Joint("revolute", "arm", joint_to_child=down, **hinge),
            "moving": Joint(kind, "nut", **({} if joint_type.is_free else place), **more),
            "elbow": Joint("revolute", "rod", "nut", joint_to_child=down, **hinge),
        },
        gravity=9.81,
        dimensions=n,
    )


def numbered(names: Sequence[str], values: Iterable[float]) -> dict[str, float]:
    return dict(zip(names, map(float, values), strict=True))


def somewhere(model: Model, seed: int) -> dict[str, float]:
    """Random states; quaternions have the length 1."""
    rng = np.random.default_rng(seed)
    names = [v.name for v in model_program(model).states]
    values = numbered(names, rng.uniform(-0.8, 0.8, len(names)))
    for owner in {name.removesuffix(".e0") for name in names if name.endswith(".e0")}:
        e = [f"{owner}.e{k}" for k in range(4)]
        values |= numbered(
            e, np.array([values[k] for k in e]) / np.hypot.reduce([values[k] for k in e])
        )
    return values


@pytest.mark.parametrize(("dimensions", "kind"), EVERY)
def test_velocities_and_accelerations_are_those_of_the_motion(dimensions: int, kind: str) -> None:
    """And the power of gravity is all that changes the kinetic energy."""
    model = machine(dimensions, kind)
    program = model_program(model)
    evaluated, values = Evaluated(program), somewhere(model, 1)
    rates, found = evaluated.rates(values), evaluated.outputs(values)
    before, after = (
        evaluated.outputs({name: value + h * rates[name] for name, value in values.items()})
        for h in (-STEP, STEP)
    )
    change = {name: (after[name] - before[name]) / (2 * STEP) for name in found}
    checked = [v for v in program.outputs if v.derivative_of in change]
    assert len(checked) >= 3
    for v in checked:
        assert found[v.name] == pytest.approx(change[v.derivative_of or ""], abs=1e-6), v.name
    assert change["energy.total"] == pytest.approx(0.0, abs=1e-6)
    assert abs(change["energy.kinetic"]) > 0.1


@pytest.mark.parametrize(("dimensions", "kind"), EVERY)
def test_the_two_algorithms_share_mass_matrix_reactions_and_derivatives(
    dimensions: int, kind: str
) -> None:
    """Of the recursion, which goes around its solution, and the closed form, which goes through."""
    model = machine(dimensions, kind)
    programs = [recorded(model, topology(model), a) for a in (Recursion, ClosedForm)]
    values = somewhere(model, 2)
    first, second = (Evaluated(p).outputs(values) for p in programs)
    assert first == pytest.approx(second, rel=1e-9, abs=1e-9)
    seeds = {f"d({name})": 0.3 - 0.1 * k for k, name in enumerate(values)}
    one, other = (Evaluated(tangent(p, [*values])).outputs(values | seeds) for p in programs)
    assert one == pytest.approx(other, rel=1e-8, abs=1e-8)
    owners = [
        (f"body.{link.body}" if link.joint_type.is_free else f"joint.{link.joint_name}", link)
        for link in topology(model).links
    ]
    u = [values[f"{owner}.{name}"] for owner, one in owners for name in one.joint_type.velocities]
    M = np.reshape([*Evaluated(mass_matrix_program(model)).outputs(values).values()], [len(u)] * 2)
    assert u @ M @ u / 2 == pytest.approx(first["energy.kinetic"], rel=1e-12)


PLANE = """\
name: press
bodies: {nut: {mass: 2, inertia: 0.5}, top: {mass: 1, inertia: 1}}
joints: {rail: {type: prismatic, child: top, parent: nut, direction: [1, 0]},
         screw: {type: KIND, child: nut"""
SPACE = PLANE.replace("name: press", "name: press\ndimensions: 3").replace("0.5", "[1, 1, 1]")
SPACE = SPACE.replace("inertia: 1}", "inertia: [1, 1, 1]}").replace("[1, 0]", "[1, 0, 0]")


@pytest.mark.parametrize(("dimensions", "kind"), EVERY)
def test_a_file_an_fmu_and_pictures(dimensions: int, kind: str, tmp_path: Path) -> None:
    joint_type, path = joint_of(dimensions, kind), tmp_path / "press.model.yaml"
    given = {"axis": "[0, 0, 1]", "second_axis": "[0, 1, 0]"}
    given = {name: given[name] for name in joint_type.axes}
    if joint_type.has_direction:
        given["direction"] = "[0, 1]" if dimensions == 2 else "[0, 1, 0]"
    vectors = [f", {name}: {value}" for name, value in given.items()]
    initial = f", initial: {{{joint_type.start_keys[0]}: 0.1}}" if joint_type.start_keys else ""

    def written(kind: str, *more: str) -> Path:
        text = (SPACE if dimensions == 3 else PLANE).replace("KIND", kind)
        path.write_text("".join([text, *more, "}}\n"]), "utf-8")
        return path

    model = load_model(written(kind, *vectors, initial))
    assert model.joints["screw"].type == kind
    for wrong, said in (
        ((kind, *vectors, ", initial: {wrong: 1}"), f"a {kind} joint has no initial"),
        ((f"{kind}x", *vectors), f"did you mean '{kind}'"),
        *(((kind, *vectors[:k], *vectors[k + 1 :]), name) for k, name in enumerate(given)),
    ):
        with pytest.raises(InputError, match=said):
            load_model(written(*wrong))
    names = set(read_description(build_fmu(model_program(model), tmp_path / "press.fmu")).variables)
    owner = "body.nut" if joint_type.is_free else "joint.screw"
    assert {f"{owner}.{name}" for name in joint_type.positions} <= names
    assert draw_model(model, tmp_path / "press.svg").stat().st_size > 1000
    whole = machine(dimensions, kind)
    page = animate(whole, simulate(whole, stop_time=0.1), tmp_path / "a.html").read_text("utf-8")
    assert '"hinges": [[' in page or '"hinges":[[' in page or joint_type.is_free


@pytest.mark.parametrize("dimensions", [2, 3])
def test_the_docs_have_a_row_for_every_type_with_its_start_keys(dimensions: int) -> None:
    page = PAGE.read_text("utf-8")
    space = page.index("## Models in space")
    part = page[:space] if dimensions == 2 else page[space:]
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \|", part, re.MULTILINE)
    told = {name: set(re.findall(r"`(\w+)`", keys)) for name, keys in rows}
    for n, name in OWN:
        assert n != dimensions or told[name] == set(joint_of(n, name).start_keys), name


def test_types_have_their_names_and_angles_come_last() -> None:
    """The topology and the recursion rely on the order."""
    assert {*JOINT_TYPES[2]} - {"screw", "pin_in_slot"} < {*JOINT_TYPES[3]}
    for types in JOINT_TYPES.values():
        for name, joint_type in types.items():
            assert joint_type.name == name
            angles = [c.is_angle for c in joint_type.coordinates]
            assert angles == sorted(angles)
            assert joint_type.turns == tuple(sorted(joint_type.turns))
            assert not joint_type.frees_rotation or joint_type.turns[-1]


def plus(*vectors: tuple[Any, Any]) -> tuple[Any, Any]:
    return sum(x for x, _ in vectors), sum(z for _, z in vectors)


def lagrange(kind: str, *, relative: bool) -> tuple[Model, Mechanism]:
    """A machine with a spring, and the same from the positions of its bodies, by hand."""
    model = machine(2, kind, coordinate="relative" if relative else "absolute")
    model = Model(
        "machine", model.bodies, model.joints, gravity=9.81,
        loads={"coil": TorsionSpring(("arm", "nut"), stiffness=7.0, angle=0.3)},
    )  # fmt: skip
    mechanism = Mechanism("a s theta b" if kind == "pin_in_slot" else "a q b")
    a, *moving, b = mechanism.q
    q: Any = moving[-1]
    angle = a + q if relative or kind == "screw" else q
    slot = kind == "pin_in_slot"
    x, z = (0.8 * moving[0], 0.6 * moving[0]) if slot else (0.4 * q, 0.3 * q)
    arm_at = turned(0, -0.5, a)
    nut_at = plus(arm_at, turned(0.1 + x, -0.4 + z, a), turned(0.3, 0.2, angle))
    rod_at = plus(nut_at, turned(0, -0.5, b))
    for mass, at, turn in ((3, arm_at, a), (2, nut_at, angle), (1, rod_at, b)):
        mechanism.body(*at, turn, mass=mass, inertia=0.4, g=9.81)
    mechanism.spring(7, angle - a - 0.3)
    return model, mechanism


@pytest.mark.parametrize(
    ("kind", "relative"), [("screw", False), ("pin_in_slot", False), ("pin_in_slot", True)]
)
def test_accelerations_of_new_types_are_those_of_lagrange(kind: str, *, relative: bool) -> None:
    """1e-10: double precision, and a mass matrix with a condition number below 1e4."""
    model, mechanism = lagrange(kind, relative=relative)
    program = model_program(model)
    names = [v.name for v in program.states]
    rng = np.random.default_rng(5)
    for _ in range(4):
        q, u = rng.uniform(-1, 1, len(mechanism.q)), rng.uniform(-2, 2, len(mechanism.q))
        expected = mechanism.accelerations(
            dict(zip([*mechanism.q, *mechanism.u], [*q, *u], strict=True))
        )
        rates = Evaluated(program).rates(numbered(names[::2], q) | numbered(names[1::2], u))
        got = [rates[name] for name in names[1::2]]
        assert got == pytest.approx(expected, rel=0, abs=RELATIVE * abs(expected).max())
