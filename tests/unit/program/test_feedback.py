"""Programs whose inputs follow a law."""

from __future__ import annotations

from support.programs import Evaluated

from m4e_fmi.program import Recorder, Variable, sin, with_feedback


def mass() -> Recorder:
    r = Recorder("mass", "a mass with a force")
    m = r.parameter(Variable("m", "kg", "mass", start=2.0))
    force = r.input(Variable("force", "N", "force"))
    wind = r.input(Variable("wind", "N", "wind", start=1.0))
    r.state(Variable("x", "m", "position"))
    v = r.state(Variable("v", "m/s", "velocity", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", (force + wind) / m)
    r.output(Variable("power", "W", "of the force"), force * v)
    r.calculate(Variable("weight", "N", "weight"), m * 9.81)
    return r


def test_a_law_takes_the_place_of_an_input() -> None:
    program = with_feedback(
        mass().program(), {"force": lambda x: -3.0 * x["x"] - x["m"] * x["v"] + sin(x["time"])}
    )
    assert [v.name for v in program.inputs] == ["wind"]
    found = Evaluated(program)
    values = {"x": 0.5, "v": 0.25}
    force = -3.0 * 0.5 - 2.0 * 0.25
    assert found.rates(values) == {"x": 0.25, "v": (force + 1.0) / 2.0}
    assert found.outputs(values) == {"power": force * 0.25, "force": force}
    assert found.calculated({}) == {"weight": 2.0 * 9.81}
    assert found.rates(values, t=1.0)["v"] > found.rates(values)["v"]
