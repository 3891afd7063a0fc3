"""New types of joints, each in one file of `tests/support`, through all of the package."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
import sympy as sp
from support.lagrange import RELATIVE, Mechanism, turned
from support.pin_in_slot import PinInSlot
from support.programs import Evaluated
from support.screw import Screw

from m4e_fmi import build_fmu, read_description
from m4e_fmi.errors import InputError
from m4e_fmi.joints import JOINT_TYPES
from m4e_fmi.model import Body, Joint, JointEffort, JointStop, Model, TorsionSpring, load_model
from m4e_fmi.multibody import Equations, mass_matrix_program, model_program, topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.model_program.recording import recorded
from m4e_fmi.multibody.sensitivity import Recursion
from m4e_fmi.program import tangent
from m4e_fmi.report.drawing.animation import animate
from m4e_fmi.report.drawing.parts import joint_outlines
from m4e_fmi.report.drawing.scene import scene
from m4e_fmi.report.drawing.schematic import draw_model
from m4e_fmi.simulate import simulate


@pytest.fixture(autouse=True)
def new_types(monkeypatch: pytest.MonkeyPatch) -> None:
    for joint_type in (Screw(), PinInSlot()):
        monkeypatch.setitem(JOINT_TYPES[2], joint_type.name, joint_type)


def nut(**more: JointEffort | JointStop) -> Model:
    """2 kg on a vertical screw with a pitch of 0.3 m/rad."""
    screw = Joint("screw", "nut", direction=(0.0, 0.3), initial={"q": 0.1})
    return Model("press", {"nut": Body(2.0, 0.5)}, {"screw": screw}, loads=more, gravity=9.81)


def arm(kind: str, coordinate: Literal["absolute", "relative"] = "absolute") -> Model:
    """An arm, a nut or pin that moves along it, and a rod and a block that hang on that."""
    return Model(
        "machine",
        {
            "arm": Body(3.0, 0.4),
            "nut": Body(2.0, 0.5),
            "rod": Body(1.0, 0.2),
            "block": Body(0.7, 0.1),
        },
        {
            "shoulder": Joint("revolute", "arm", joint_to_child=(0.2, -0.5)),
            "moving": Joint(kind, "nut", "arm", (0.1, -0.4), (0.3, 0.2), (0.4, 0.3), coordinate),
            "elbow": Joint("revolute", "rod", "nut", (0.2, 0.1), (0.0, -0.6)),
            "rail": Joint("prismatic", "block", "nut", (0.0, 0.3), direction=(1.0, -2.0)),
        },
        loads={"coil": TorsionSpring(("arm", "nut"), stiffness=7.0, angle=0.3)},
        gravity=9.81,
    )


def plus(*vectors: tuple[Any, Any]) -> tuple[Any, Any]:
    return sum(x for x, _ in vectors), sum(z for _, z in vectors)


def lagrange(kind: str, *, relative: bool) -> Mechanism:
    """The same from the positions of the bodies, written down by hand."""
    machine = Mechanism("a s theta b r" if kind == "slot" else "a q b r")
    a, *moving, b, r = machine.q
    q: Any = moving[-1]
    angle = a + q if relative else q
    x, z = (0.8 * moving[0], 0.6 * moving[0]) if kind == "slot" else (0.4 * q, 0.3 * q)
    slid: Any = r / sp.sqrt(5)
    arm_at = turned(0.2, -0.5, a)
    nut_at = plus(arm_at, turned(0.1 + x, -0.4 + z, a), turned(0.3, 0.2, angle))
    rod_at = plus(nut_at, turned(0.2, 0.1, angle), turned(0, -0.6, b))
    block_at = plus(nut_at, turned(slid, 0.3 - 2 * slid, angle))
    machine.body(*arm_at, a, mass=3, inertia=0.4, g=9.81)
    machine.body(*nut_at, angle, mass=2, inertia=0.5, g=9.81)
    machine.body(*rod_at, b, mass=1, inertia=0.2, g=9.81)
    machine.body(*block_at, angle, mass=0.7, inertia=0.1, g=9.81)
    machine.spring(7, angle - a - 0.3)
    return machine


def numbered(tree: Sequence[str], values: Iterable[float]) -> dict[str, float]:
    return dict(zip(tree, map(float, values), strict=True))


@pytest.mark.parametrize("algorithm", [Recursion, ClosedForm])
@pytest.mark.parametrize(
    ("kind", "coordinate"),
    [("screw", "absolute"), ("pin_in_slot", "absolute"), ("pin_in_slot", "relative")],
)
def test_accelerations_are_those_of_lagrange(
    kind: str,
    coordinate: Literal["absolute", "relative"],
    algorithm: type[Recursion] | type[ClosedForm],
) -> None:
    """1e-10: double precision, and a mass matrix with a condition number below 1e4."""
    model = arm(kind, coordinate)
    program = recorded(model, topology(model), algorithm)
    mechanism = lagrange(
        "slot" if kind == "pin_in_slot" else kind,
        relative=kind == "screw" or coordinate == "relative",
    )
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


@pytest.mark.parametrize("kind", ["screw", "pin_in_slot"])
def test_the_two_algorithms_share_mass_matrix_reactions_and_derivatives(kind: str) -> None:
    """Of the recursion, which goes around its solution, and the closed form, which goes through."""
    model = arm(kind)
    programs = [recorded(model, topology(model), a) for a in (Recursion, ClosedForm)]
    states = [v.name for v in programs[0].states]
    rng = np.random.default_rng(6)
    values = numbered(states, rng.uniform(-1, 1, len(states)))
    first, second = (Evaluated(p).outputs(values) for p in programs)
    assert first == pytest.approx(second, rel=1e-9, abs=1e-9)
    seeds = {f"d({name})": float(rng.uniform(-1, 1)) for name in states}
    one, other = (Evaluated(tangent(p, states)).outputs({**values, **seeds}) for p in programs)
    assert one == pytest.approx(other, rel=1e-8, abs=1e-8)
    rows = Evaluated(mass_matrix_program(model)).outputs(values)
    M = np.array(list(rows.values())).reshape([len(states) // 2] * 2)
    u = np.array([values[name] for name in states[1::2]])
    assert u @ M @ u / 2 == pytest.approx(first["energy.kinetic"], rel=1e-12)


def test_a_driven_screw_as_written_down_by_hand() -> None:
    """(m h² + J) φ̈ = τ − m g h; the thread carries m (h φ̈ + g) and J φ̈."""
    program = Evaluated(model_program(nut()))
    state = {"joint.screw.q": 0.7, "joint.screw.effort": 11.0}
    alpha = (11.0 - 2.0 * 9.81 * 0.3) / (2.0 * 0.3**2 + 0.5)
    assert program.rates(state)["joint.screw.u"] == pytest.approx(alpha, rel=1e-14)
    out = program.outputs(state)
    assert out["body.nut.z"] == pytest.approx(0.21, rel=1e-14)
    assert out["joint.screw.reaction_z"] == pytest.approx(2 * (0.3 * alpha + 9.81), rel=1e-14)
    assert out["joint.screw.reaction_moment"] == pytest.approx(0.5 * alpha, rel=1e-14)
    equations = Equations(nut())
    assert equations.mass_matrix[0] == sp.Rational("0.3") ** 2 * 2 + sp.Rational("0.5")
    assert list(equations.topology.coordinate_names) == ["Phi_1"]


@pytest.mark.parametrize("kind", ["screw", "pin_in_slot"])
def test_energy_is_kept(kind: str) -> None:
    """1e-6 J of about 60: a local error of 1e-10 per step, some hundred steps."""
    model = arm(kind)
    start = {"joint.shoulder.q": 1.2, "joint.elbow.u": 2.0, "joint.rail.u": -0.5}
    result = simulate(model, stop_time=2.0, start_values=start, tolerance=1e-10)
    energy = result["energy.total"]
    assert np.ptp(result["energy.kinetic"]) > 1.0
    assert energy == pytest.approx(np.full(energy.shape, energy[0]), abs=1e-6)


def test_loads_see_the_coordinate_of_a_screw() -> None:
    """Held by an effort of m g h − 4 q: q follows (m h² + J) φ̈ = −4 q."""
    model = nut(hold=JointEffort("screw", "2*9.81*0.3 - 4*joint.screw.q"))
    result = simulate(model, stop_time=1.0, tolerance=1e-10)
    expected = 0.1 * np.cos(np.sqrt(4 / 0.68) * result.time)
    assert result["joint.screw.q"] == pytest.approx(expected, abs=1e-8)
    stop = model_program(nut(end=JointStop("screw", 100.0, upper=1.0)))
    units = {v.name: v.unit for v in stop.outputs}
    assert (units["load.end.gap"], units["load.end.effort"]) == ("rad", "N.m")


def test_an_fmu_and_pictures_of_it(tmp_path: Path) -> None:
    fmu = build_fmu(model_program(nut()), tmp_path / "press.fmu")
    names = set(read_description(fmu).variables)
    assert {"joint.screw.q", "joint.screw.effort", "joint.screw.reaction_z"} <= names
    assert draw_model(nut(), tmp_path / "press.svg").stat().st_size > 1000
    shown = scene(nut())
    (circle,) = joint_outlines(shown, shown.start, size=1.0)
    assert (circle.max(axis=0) + circle.min(axis=0)) / 2 == pytest.approx([0, 0.03], abs=1e-12)
    model = arm("pin_in_slot")
    animate(model, simulate(model, stop_time=0.2), tmp_path / "machine.html")
    assert '"sleeve"' in (tmp_path / "machine.html").read_text("utf-8")


FILE = """\
name: press
bodies:
  nut: {{mass: 2, inertia: 0.5}}
joints:
  screw: {{type: {kind}, child: nut, direction: [0, 0.3], initial: {{{key}: 0.1}}}}
"""


def test_a_file_with_it_is_read_and_checked(tmp_path: Path) -> None:
    path = tmp_path / "press.model.yaml"
    path.write_text(FILE.format(kind="screw", key="q"), "utf-8")
    assert load_model(path).joints == nut().joints
    path.write_text(FILE.format(kind="screw", key="x"), "utf-8")
    with pytest.raises(InputError, match="a screw joint has no initial 'x'"):
        load_model(path)
    path.write_text(FILE.format(kind="screv", key="q"), "utf-8")
    with pytest.raises(InputError, match="did you mean 'screw'"):
        load_model(path)
    joint = Joint("pin_in_slot", "nut")
    with pytest.raises(InputError, match="a pin_in_slot joint needs a direction"):
        Model("press", {"nut": Body(1.0, 1.0)}, {"pin": joint})
