"""Notes on equilibria: what grows, and what is beyond its limits."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from m4e_fmi.analysis import equilibrium, linearize, modes
from m4e_fmi.analysis.rest_notes import growth, limits_left, rest_notes
from m4e_fmi.cli import main
from m4e_fmi.program import Connection, Program, Recorder, Variable, compose
from m4e_fmi.report import linear_json, linear_text
from m4e_fmi.simulate import simulate

STIFFNESS, MASS = 3.0, 2.0
TOO_SOFT = 1e-4
"""By how much the slope of the law is more than the stiffness [N/m]."""
UPRIGHT = """\
name: upright
gravity: 9.81
bodies: {bob: {mass: 1, inertia: 4}}
joints: {hinge: {type: revolute, child: bob, joint_to_child: [0, 2], initial: {q: 0}}}
"""


class Law:
    """A force of TOO_SOFT + STIFFNESS times the place, whose slope has an error [N/m]."""

    def __init__(self, error: float) -> None:
        self.errors = {"slope": error}

    def parameters_at(self, _: object) -> dict[str, float]:
        return {"slope": STIFFNESS + TOO_SOFT}


def held(error: float) -> Program:
    """A mass on a spring, and on a law that undoes it."""
    r = Recorder("law", "")
    x, slope = r.input(Variable("x", "m", "")), r.parameter(Variable("slope", "N/m", ""))
    r.output(Variable("force", "N", ""), slope * x)
    law = r.program()
    r = Recorder("mass", "")
    force = r.input(Variable("force", "N", ""))
    x = r.state(Variable("x", "m", ""))
    v = r.state(Variable("v", "m/s", "", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", (force - STIFFNESS * x) / MASS)
    return compose(
        "whole",
        {"mass": r.program(), "law": law},
        [
            Connection(("mass", "x"), ("law", "x")),
            Connection(("law", "force"), ("mass", "force")),
        ],
        origins={"law": Law(error)},
    )


@pytest.mark.parametrize(
    ("error", "told", "note"),
    [
        (0.9 * TOO_SOFT, "UNSTABLE: a motion grows (0.00707 1/s)", "the equilibrium is unstable"),
        (1.1 * TOO_SOFT, "neutral within the error of K of law: a motion grows (0.00707 1/s)", ""),
        (300.0, "neutral within the error of K of law: a motion grows (0.00707 1/s)", ""),
    ],
)
def test_growth_that_an_error_of_a_law_may_be(error: float, told: str, note: str) -> None:
    linear = linearize(held(error), at=equilibrium(held(error), nearest=True))
    found = growth(linear)
    assert found is not None
    assert found.rate == pytest.approx(math.sqrt(TOO_SOFT / MASS), rel=1e-6)
    assert told in linear_text(linear, modes(linear), title="start")
    assert linear_json(linear, modes(linear))["neutral"] is (not note)
    (line,) = rest_notes(linear.point)
    assert line.startswith(note or "neutral")


@pytest.mark.parametrize(("start", "notes"), [(0.0, 1), (math.pi, 0)])
def test_an_unstable_equilibrium_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], start: float, notes: int
) -> None:
    """A bob on 2 m: upright it falls with √(m g l / (I + m l²)); hanging nothing is told."""
    path = tmp_path / "upright.model.yaml"
    path.write_text(UPRIGHT.replace("q: 0", f"q: {start}"), encoding="utf-8")
    line = f"note: the equilibrium is unstable: a motion grows ({math.sqrt(9.81 / 4):.3g} 1/s)\n"
    assert main(["equilibrium", str(path)]) == 0
    assert capsys.readouterr().out.count(line) == notes
    assert main(["equilibrium", str(path), "--json"]) == 0
    caught = capsys.readouterr()
    assert "joint.hinge.q" in json.loads(caught.out)
    assert caught.err.count(line) == notes


@pytest.mark.parametrize(("pull", "told"), [(10.0, False), (-30.0, True), (30.0, True)])
def test_outputs_beyond_their_limits_are_told(pull: float, told: bool) -> None:
    """A draft of pull over stiffness, which linear water knows up to ±7.5 m."""
    r = Recorder("water", "")
    x = r.state(Variable("x", "m", ""))
    v = r.state(Variable("v", "m/s", "", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", pull - STIFFNESS * x - v)
    r.output(Variable("heave", "m", "small motions", minimum=-7.5, maximum=7.5), x)
    line = f"heave: {pull / STIFFNESS:.3g} m is outside of its limits, -7.5 to 7.5 m: small motions"
    assert rest_notes(equilibrium(r.program())) == ([line] if told else [])


def test_outputs_that_leave_their_limits_in_motion_are_told_with_the_first_time() -> None:
    """Of 2 m/s from -1 m: up to 0.5 m in 0.75 s; a limit of just what is reached is kept."""
    r = Recorder("drift", "")
    x = r.state(Variable("x", "m", "", start=-1.0))
    r.rate("x", 2.0)
    r.output(Variable("near", "m", "place", minimum=-2.0, maximum=0.5), x)
    r.output(Variable("far", "m", "place", minimum=-1.0, maximum=1.0), x)
    (told,) = limits_left(simulate(r.program(), stop_time=1.0, output_interval=0.1))
    assert told == "near is 0.6 m at t = 0.8 s, outside of its limits, -2 to 0.5 m: place"
