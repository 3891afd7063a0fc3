"""Messages of FMUs in a run: shown at once, in the summary, the outcome and the file."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import pytest
from support.small_systems import Fmus, system

from m4e_fmi.cosim import (
    CouplingErrorReport,
    Outcome,
    Simulation,
    load,
    run,
)
from m4e_fmi.errors import RunError
from m4e_fmi.report import run_text

VERSIONS = ["talker", "1:talker", "3:talker"]


def talk(
    fmus: Fmus, name: str = "talker", *, file: Path | None = None, **start: float
) -> tuple[Outcome, list[str]]:
    """A run of 1 s in steps of 0.1 s of a talker, and the lines that it gave at once."""
    lines: list[str] = []
    pump = system(fmus, {"pump": name}, start={"pump": start})
    return run(pump, results=file, warn=lines.append), lines


@pytest.mark.verifies(
    "count of the messages of an FMU that logs one in each step",
    analytic="number of the steps",
    tolerance="identical",
)
@pytest.mark.parametrize("name", VERSIONS)
@pytest.mark.parametrize(("status", "word"), [(1, "warning"), (2, "discard"), (3, "error")])
def test_a_message_in_each_step_is_one(c_fmu: Fmus, name: str, status: int, word: str) -> None:
    outcome, lines = talk(c_fmu, name, logged=status, when=0.3)
    assert lines == [f"pump, {word} at t = 0.3 s: line aaa is 300 m too long, t = 0.3"]
    (message,) = outcome.messages
    assert (message.component, message.status, message.count) == ("pump", word, 7)
    assert (message.first, message.last) == (pytest.approx(0.3), pytest.approx(0.9))


@pytest.mark.parametrize("name", VERSIONS)
def test_a_step_answered_with_warning_is_told(c_fmu: Fmus, name: str) -> None:
    outcome, _ = talk(c_fmu, name, answer=1, count=0, when=0.3)
    (message,) = outcome.messages
    assert str(message) == (
        "pump, warning, 7 times, t = 0.3 s to 0.9 s: fmi2DoStep returned Warning, "
        "and the FMU logged nothing"
    )
    # where fix the problem stated by the FMU, that is enough
    outcome, _ = talk(c_fmu, name, answer=1, when=0.3)
    assert [m.text for m in outcome.messages] == ["line aaa is 300 m too long, t = 0.3"]


def test_messages_are_counted(c_fmu: Fmus) -> None:
    """Where algorithms make several steps of the FMU in each; or it logs several in one."""
    outcome, _ = talk(c_fmu, count=3, when=0.3)
    (message,) = outcome.messages
    assert message.count == 21
    assert "pump, warning, 21 times, t = 0.3 s to 0.9 s" in str(message)


def test_plain_messages_are_no_warnings(c_fmu: Fmus) -> None:
    outcome, lines = talk(c_fmu, logged=0)
    assert (outcome.messages, lines) == ((), [])


def test_the_summary_and_the_file_have_them(c_fmu: Fmus, tmp_path: Path) -> None:
    outcome, _ = talk(c_fmu, file=tmp_path / "r.nc", when=0.3)
    line = "pump, warning, 7 times, t = 0.3 s to 0.9 s: line aaa is 300 m too long, t = 0.3"
    assert f"messages of FMUs:\n  {line}" in run_text(outcome)
    assert load(tmp_path / "r.nc").attributes["messages"] == line


def test_a_flood_is_bounded(c_fmu: Fmus, tmp_path: Path) -> None:
    tracemalloc.start()
    outcome, lines = talk(c_fmu, file=tmp_path / "r.nc", count=2_000, kinds=2_000)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert sum(message.count for message in outcome.messages) == 20_000
    assert len(outcome.messages) == len(lines) == 21
    assert "further messages" in outcome.messages[-1].text
    assert outcome.messages[-1].count == 20_000 - 20 * 10
    assert len(run_text(outcome).splitlines()) < 40
    assert peak < 6e6  # that of all messages would be several times as much


def test_the_steps_that_tell_the_error_are_not_heard(c_fmu: Fmus) -> None:
    lines: list[str] = []
    parts = {"a": "integrator+state", "b": "talker+state", "c": "integrator+state"}
    connections, settings = ("a.y -> c.u", "c.y -> a.u"), Simulation(1.0, 0.1, "gauss_seidel")
    start: dict[str, dict[str, float | str]] = {"a": {"y": 1.0}, "b": {"answer": 1.0}}
    ring = system(c_fmu, parts, *connections, start=start, simulation=settings)
    outcome = run(ring, warn=lines.append)
    assert outcome.messages[0].count == 10
    assert [line[:9] for line in lines] == ["warning: ", "b, warnin"]
    start["b"]["count"] = 0.0
    quiet = system(c_fmu, parts, *connections, start=start, simulation=settings)
    assert run(quiet).messages[0].count == 10


@pytest.mark.parametrize(
    "name",
    [
        "blind_integrator+loud",
        "blind_integrator+state+loud",
        "blind_integrator+loud+anonymous",
        "3:blind_integrator+state+loud",
    ],
)
def test_instances_beside_the_run_are_not_heard(
    c_fmu: Fmus, name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """Neither those that are probed nor those that tell the coupling error."""
    ring = ("a.y -> b.u", "b.y * -1 -> a.u")
    lines: list[str] = []
    begin = {part: {"y": 1.0} for part in "ab"}
    outcome = run(system(c_fmu, dict.fromkeys("ab", name), *ring, start=begin), warn=lines.append)
    assert any("probed" in note for note in outcome.notes)
    assert isinstance(outcome.certificate, CouplingErrorReport)
    told = [f"{part}, warning at t = 0 s: here is {part}" for part in "ab"]
    assert (lines, [str(message) for message in outcome.messages]) == (told, told)
    assert capfd.readouterr() == ("", "")


def test_what_a_listener_raises_ends_the_run(c_fmu: Fmus) -> None:
    class StopError(Exception):
        pass

    def refuse(_: str) -> None:
        raise StopError

    with pytest.raises(StopError):
        run(system(c_fmu, {"pump": "talker"}), warn=refuse)


def test_messages_of_a_run_that_fails_are_in_its_results(c_fmu: Fmus, tmp_path: Path) -> None:
    parts, start = {"pump": "talker", "rogue": "rogue"}, {"rogue": {"what": 3.0, "when": 0.5}}
    with pytest.raises(RunError):
        run(system(c_fmu, parts, start=start), results=tmp_path / "r.nc")
    lines = load(tmp_path / "r.nc").attributes["messages"].splitlines()
    assert [line.split(",")[0] for line in lines] == ["pump", "rogue"]
    assert "rogue, error at t = 0.4 s: the pump ran dry" in lines[1]
