"""Units of parameters in expressions: what does not belong together is refused, nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.model import load_model
from m4e_fmi.model.dimensions import DimensionError, dimension, dimension_of, told
from m4e_fmi.model.expression import parse

ROOT = Path(__file__).parents[3]
UNITS = {
    "m": "kg", "L": "cm", "k": "kN/m", "c": "N.s/m", "F": "N", "J": "kg.m2", "w": "rpm",
    "phi": "deg", "kt": "N.m/rad", "n": "1", "g": "m/s2", "share": "%",
}  # fmt: skip
KNOWN = {name: dimension_of(unit) for name, unit in UNITS.items()}
MODEL = """\
name: d
parameters:
{parameters}
tables: {{gust: {{times: [0, 1], values: [0, 1], unit: kN}}}}
bodies: {{b: {{mass: m, inertia: J}}}}
joints:
  pin: {{type: revolute, child: b, joint_to_child: [0, -L/2], initial: {{q: phi, u: w}}}}
points: {{p: {{body: b, at: [0, L]}}, o: {{body: ground, at: [0, 0]}}}}
loads:
  load: {load}
"""


@pytest.mark.parametrize(("text", "unit"), [
    ("m", "kg"), ("m*g", "N"), ("k*L", "N"), ("J/m/L", "m"), ("(k*m)**0.5", "kg/s"),
    ("c/sqrt(k*m)", "1"), ("max(L, J/m/L)", "m"), ("-abs(F)", "N"), ("L + 2", "m"),
    ("L**2*m", "kg.m2"), ("L**-2*J", "kg"), ("kt*phi", "N.m"), ("F*L + kt", "N.m"),
    ("(L + 1)*k", "N"), ("F*sin(phi)/F", None), ("share*F", "N"),
    # a number, the time, the motion, a function or a unit of 1 may be anything
    ("2*m", None), ("n*m", None), ("t*F", None), ("sin(2*t)", None), ("joint.pin.q*k", None),
    ("m**n", None), ("n + 3", None), ("pi*2", None),
])  # fmt: skip
def test_dimensions(text: str, unit: str | None) -> None:
    found = dimension(parse(text), KNOWN)
    plain = tuple(0 for _ in dimension_of("kg") or ())
    expected = None if unit is None else plain if unit == "1" else dimension_of(unit)
    assert found == expected


@pytest.mark.parametrize(("text", "why"), [
    ("m + L", r"m \[kg\] \+ L \[m\] have different dimensions"),
    ("F - k", r"F \[N\] - k \[N/m\]"),
    ("2*(k*L - m)", r"\(k \* L\) \[N\] - m \[kg\]"),
    ("min(L, m)", r"L \[m\] and m \[kg\]"),
    ("sin(L)", r"argument of sin\(L\) is in m, not a number"),
    ("exp(F/k)", r"argument of exp\(\(F / k\)\) is in m"),
    ("2**L", "exponent L is in m"),
    ("atan2(L, F)", r"L \[m\] and F \[N\]"),
])  # fmt: skip
def test_what_does_not_belong_together(text: str, why: str) -> None:
    with pytest.raises(DimensionError, match=why):
        dimension(parse(text), KNOWN)


def test_dimensions_are_told_as_units() -> None:
    assert told(dimension_of("MN/m")) == "N/m"
    assert told(dimension_of("kg.m2/s")) == "N.m.s"
    assert told(dimension_of("V/m")) == "kg.m.s-3.A-1"


def model(folder: Path, load: str) -> Path:
    path = folder / "d.model.yaml"
    parameters = "\n".join(f"  {n}: {{value: 0.5, unit: {u!r}}}" for n, u in UNITS.items())
    path.write_text(MODEL.format(parameters=parameters, load=load), encoding="utf-8")
    return path


@pytest.mark.parametrize(("load", "told", "remedy"), [
    ("{type: tension_spring, points: [o, p], stiffness: m, length: L}",
     "stiffness: m is in kg, expected N/m", "did you mean 'k', in N/m?"),
    ("{type: tension_spring, points: [o, p], length: L, law: l*k + m*g + L*F}",
     "have different dimensions", ""),
    ("{type: tension_spring, points: [o, p], length: L, law: F*L}",
     "law: F*L is in N.m, expected N", "did you mean 'F' or 'gust', in N?"),
    ("{type: torsion_spring, bodies: [ground, b], stiffness: k}",
     "stiffness: k is in kN/m, expected N.m/rad", "did you mean 'kt'"),
    ("{type: joint_effort, joint: pin, effort: F}", "effort: F is in N, expected N.m", "'kt'"),
    ("{type: joint_stop, joint: pin, stiffness: kt, upper: L}",
     "upper: L is in cm, expected rad", "did you mean 'phi'"),
    ("{type: point_force, point: p, force: [m, 0]}", "force: m is in kg, expected N", "'F'"),
    ("{type: point_drag, point: p, coefficient: 3, flow: [w, 0]}",
     "flow: w is in rpm, expected m/s", ""),
])  # fmt: skip
def test_a_wrong_unit_is_told_where_it_is_used(
    tmp_path: Path, load: str, told: str, remedy: str
) -> None:
    with pytest.raises(InputError) as caught:
        load_model(model(tmp_path, load))
    (problem,) = caught.value.problems
    assert told in problem.message
    assert remedy in problem.remedy
    assert problem.line == 21
    assert problem.column > 10


@pytest.mark.parametrize("load", [
    "{type: tension_spring, points: [o, p], stiffness: k, length: L}",
    "{type: tension_damper, points: [o, p], damping: 2*m}",
    "{type: tension_spring, points: [o, p], length: L, law: 40*l + 3*l**3 + F*tanh(l)}",
    "{type: point_force, point: p, force: [gust + F*sin(w*t), 'sin(2*t)']}",
    "{type: joint_effort, joint: pin, effort: -30*joint.pin.q - 4*joint.pin.u + F*L}",
    "{type: torsion_spring, bodies: [ground, b], stiffness: kt, angle: phi}",
    "{type: joint_friction, joint: pin, effort: F*L, velocity: w}",
])  # fmt: skip
def test_what_is_right_passes(tmp_path: Path, load: str) -> None:
    assert load_model(model(tmp_path, load)).loads


def test_a_unit_at_a_joint_that_is_wrong_itself_is_not_looked_at(tmp_path: Path) -> None:
    path = model(tmp_path, "{type: joint_effort, joint: pin, effort: F}")
    path.write_text(path.read_text().replace("type: revolute", "type: revolute, coordinate: 3"))
    with pytest.raises(InputError) as caught:
        load_model(path)
    (problem,) = caught.value.problems
    assert "unknown coordinate 3" in problem.message


SPACE = """name: d
dimensions: 3
parameters:
{parameters}
bodies: {{b: {{mass: m, inertia: [1, 1, 1]}}}}
joints: {{pin: {{type: {kind}, child: b, axis: [0, 0, 1]{more}}}}}
loads:
  load: {load}
"""
KINDS = {"cylindrical": "", "planar": ", direction: [1, 0, 0]"}


def in_space(folder: Path, kind: str, load: str) -> Path:
    path = folder / "d.model.yaml"
    parameters = "\n".join(f"  {n}: {{value: 0.5, unit: {u!r}}}" for n, u in UNITS.items())
    path.write_text(
        SPACE.format(parameters=parameters, kind=kind, more=KINDS[kind], load=load), "utf-8"
    )
    return path


@pytest.mark.parametrize(
    ("kind", "slide", "turn"), [("cylindrical", "q1", "q2"), ("planar", "q2", "q3")]
)
def test_units_follow_the_coordinate_of_a_joint_with_several(
    tmp_path: Path, kind: str, slide: str, turn: str
) -> None:
    right = (
        ("joint_effort", slide, "effort: F"),
        ("joint_effort", turn, "effort: F*L"),
        ("joint_friction", slide, "effort: F, velocity: L*w"),
        ("joint_friction", turn, "effort: F*L, velocity: w"),
        ("joint_stop", slide, "stiffness: k, upper: L"),
        ("joint_stop", turn, "stiffness: kt, upper: phi"),
    )
    for load, along, numbers in right:
        text = f"{{type: {load}, joint: pin, along: {along}, {numbers}}}"
        assert load_model(in_space(tmp_path, kind, text)).loads
        other = turn if along == slide else slide
        with pytest.raises(InputError, match="expected") as caught:
            load_model(in_space(tmp_path, kind, text.replace(along, other)))
        assert len(caught.value.problems) == numbers.count(":")
