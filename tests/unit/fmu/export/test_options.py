"""Options of `build_fmu`, and which outputs and names an FMU has by them."""

from __future__ import annotations

from typing import Any

import pytest
from support.driven import driven

from m4e_fmi.errors import InputError
from m4e_fmi.fmu.export.from_program import with_rates
from m4e_fmi.fmu.export.options import Options
from m4e_fmi.fmu.export.program_files import model_file
from m4e_fmi.fmu.export.selection import renamed, with_outputs
from m4e_fmi.program import Program, rate_entries
from m4e_fmi.program.binary_form import decode
from m4e_fmi.runtime.engine import Engine


def names(program: Program) -> list[str]:
    return [v.name for v in program.outputs]


class TestOptions:
    @pytest.mark.parametrize(
        ("option", "value", "message"),
        [
            ("method", "rodass", "did you mean 'rodas'"),
            ("fmi", "4", "there is no FMI version '4'"),
            ("tolerance", 0.0, "the tolerance must be positive, got 0"),
            ("stop_time", float("inf"), "the stop time must be positive, got inf"),
            ("step_size", -1.0, "the step size must be positive"),
            ("documentation", {"resources/model.m4e": b""}, "not a place for documentation"),
        ],
    )
    def test_one_that_is_none(self, option: str, value: Any, message: str) -> None:
        with pytest.raises(InputError, match=message):
            Options(**{option: value})

    def test_all_that_is_wrong_at_once(self) -> None:
        with pytest.raises(InputError) as caught:
            Options(method="euler", step_size=0.0)
        assert len(caught.value.problems) == 2


class TestOutputs:
    def test_those_that_match_and_the_states(self) -> None:
        program = with_outputs(driven(), ["e*y", "h?ight", "x"])
        assert names(program) == ["height", "energy"]
        assert {v.name: v.local for v in program.states} == {"x": False, "v": True}

    def test_what_only_others_need_is_not_in_the_file(self) -> None:
        full = with_rates(driven())
        chosen = with_rates(with_outputs(driven(), ["height"]))
        sizes = [len(decode(model_file(p, "dop853", {}))[0].tape) for p in (full, chosen)]
        assert sizes[1] < sizes[0]

    def test_no_link_to_one_that_is_gone(self) -> None:
        """`a` is the rate of the state v; without it the FMU shows der(v)."""
        assert "der(v)" not in names(with_rates(driven()))
        assert "der(v)" in names(with_rates(with_outputs(driven(), ["height"])))

    def test_patterns_that_match_nothing(self) -> None:
        with pytest.raises(InputError, match="did you mean 'energy'") as caught:
            with_outputs(driven(), ["enrgy", "height", "nothing.*"])
        assert len(caught.value.problems) == 2


class TestRenamed:
    def test_every_group_and_the_rates(self) -> None:
        table = {"x": "arm.tip[2].x", "force": "pull_in", "mass": "m", "energy": "'Σ E'"}
        program = renamed(with_rates(driven()), table)
        assert {v.name for v in program.states} == {"arm.tip[2].x", "v"}
        assert "der(arm.tip[2].x)" in names(program)
        rate = next(v for v in program.outputs if v.name == "der(arm.tip[2].x)")
        assert rate.derivative_of == "arm.tip[2].x"
        assert "pull_in" in {v.name for v in program.inputs}
        assert "m" in {v.name for v in program.parameters}
        assert "'Σ E'" in names(program)

    @pytest.mark.parametrize("table", [{"x": "v", "v": "x"}, {"x": "energy", "energy": "x"}])
    def test_names_may_change_places(self, table: dict[str, str]) -> None:
        full = with_rates(driven())
        program = renamed(full, table)
        before, after = Engine(full), Engine(program)
        x, u = [0.3, 0.7], [0.1] * len(full.inputs)
        for engine in (before, after):
            engine.set_inputs(u)
        assert list(before.rates(0.2, x)) == list(after.rates(0.2, x))

    def test_a_whole_group(self) -> None:
        grouped = renamed(driven(), {"x": "arm.x", "v": "arm.v"})
        program = renamed(with_rates(grouped), {"arm.*": "lever.tip.*"})
        assert [v.name for v in program.states] == ["lever.tip.x", "lever.tip.v"]
        assert program.states[1].derivative_of == "lever.tip.x"
        assert "der(lever.tip.x)" in names(program)

    def test_one_variable_gets_one_name(self) -> None:
        twice = {"arm.*": "lever.*", "arm.x": "place"}
        program = renamed(driven(), {"x": "arm.x"})
        with pytest.raises(InputError, match=r"'arm.x' would get two names: 'lever.x', 'place'"):
            renamed(program, twice)

    def test_descriptions_of_rates_have_no_old_names(self) -> None:
        program = renamed(with_rates(driven()), {"x": "place"})
        state = next(v for v in program.states if v.name == "place")
        rate = next(v for v in program.outputs if v.name == "der(place)")
        assert state.description
        assert rate.description == f"Rate: {state.description}"

    def test_same_nodes(self) -> None:
        program = with_rates(driven())
        entries = rate_entries(program)
        other = renamed(program, {"x": "place"})
        assert len(other.tape) == len(program.tape)
        assert max(e[2] for e in entries) < len(other.tape)

    @pytest.mark.parametrize(
        ("table", "message"),
        [
            ({"energie": "e"}, "did you mean 'energy'"),
            ({"arms.*": "lever.*"}, "no variable 'arms"),
            ({"energy": "x"}, "two variables would be called 'x'"),
            ({"energy": "time"}, "'time' is a reserved name"),
            ({"energy": "total energy"}, "cannot name a variable"),
            ({"energy": "2nd"}, "cannot name a variable"),
            ({"energy": "a..b"}, "cannot name a variable"),
            ({"energy": "der(x)"}, "cannot name a variable"),
        ],
    )
    def test_refused(self, table: dict[str, str], message: str) -> None:
        with pytest.raises(InputError, match=message):
            renamed(with_rates(driven()), table)
