"""Files of results that runs write: all rows, in each form, with what they say of themselves."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from support.small_systems import Fmus, oscillator, system

from m4e_fmi.cosim import (
    Network,
    Simulation,
    load,
    read_parameters,
    run,
    start,
)
from m4e_fmi.cosim.results.writer import LEAST_ROWS
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.report.text.summaries import run_text
from m4e_fmi.signals import Terminated

SHORT = Simulation(1, 0.1)


def test_results_hold_every_output_with_unit_and_name(c_fmu: Fmus, tmp_path: Path) -> None:
    step = 0.01
    settings = Simulation(2, step, output_interval=0.05)
    outcome = run(oscillator(c_fmu, settings), results=tmp_path / "out" / "r.nc")
    results = outcome.results()
    assert set(results.components) == {"body", "spring"}
    assert set(results.components["body"]) == {"body.m.x", "body.m.vx", "body.m.ax"}
    x, force = results["body.body.m.x"], results["spring.end.force_x"]
    assert (x.unit, x.long_name) == ("m", "output body.m.x")
    assert force.unit == "N"
    np.testing.assert_allclose(results.time, np.arange(0, 41) * 0.05, atol=1e-15)
    # second order: phase error t (ωH)²/24 and displacement of H²/12 times the force
    np.testing.assert_allclose(x.values, np.cos(results.time), atol=2 * step**2 / 12)
    # consistent at every point: the force is the one of this very position
    np.testing.assert_array_equal(force.values, -x.values)
    expected = {"title": "test", "algorithm": "corrector", "step_size": "0.01 s"}
    assert results.attributes.items() >= {**expected, "ended": "at the stop time"}.items()
    assert results.attributes["created"].endswith("+00:00")
    assert outcome.steps == 200


def test_results_that_fill_their_blocks_are_complete(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("m4e_fmi.cosim.results.writer.MOST_ROWS", LEAST_ROWS)
    settings = Simulation((2 * LEAST_ROWS - 1) / 10, 0.1)
    outcome = run(system(c_fmu, {"a": "rogue"}, simulation=settings), results=tmp_path / "r.nc")
    np.testing.assert_allclose(outcome.results().time, np.arange(2 * LEAST_ROWS) / 10, atol=1e-9)


def test_an_error_at_the_end_is_a_message_and_the_results_are_whole(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    given = system(c_fmu, {"a": "mass+reluctant"}, simulation=SHORT)
    outcome = run(given, results=tmp_path / "r.nc")
    (message,) = outcome.messages
    assert str(message) == "a, error at t = 1 s: fmi2Terminate answered Error"
    assert "fmi2Terminate answered Error" in run_text(outcome)
    assert len(outcome.results().time) == 11


@pytest.mark.parametrize("names", [{"a": "talker"}, {"a": "talker", "b": "kinds"}])
def test_results_that_stay_of_the_classic_form_have_all_attributes(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, names: Mapping[str, str]
) -> None:
    """There is no room for the netCDF-4 file; `kinds` has texts."""
    given = system(c_fmu, names)
    whole = run(given, results=tmp_path / "r.nc").results()

    def full(*_: object) -> None:
        raise RunError("no room")

    monkeypatch.setattr("m4e_fmi.cosim.results.writer.write_netcdf", full)
    outcome = run(given, results=tmp_path / "r.nc")
    assert "in netCDF's classic format" in outcome.notes[-1]
    found = outcome.results().attributes
    assert {"coupling_error", "messages", "ended"} <= set(found)
    assert {**found, "created": ""} == {**whole.attributes, "created": ""}
    assert list(outcome.results().series) == list(whole.series)


def test_chosen_variables_are_recorded(c_fmu: Fmus, tmp_path: Path) -> None:
    path, whole = tmp_path / "r.nc", oscillator(c_fmu, SHORT)
    chosen = run(whole, results=path, variables=["body.*x", "spring.stiffness"]).results()
    names = {"body.body.m.x", "body.body.m.vx", "body.body.m.ax", "spring.stiffness"}
    assert set(chosen.series) == names
    assert chosen["spring.stiffness"].values.tolist() == [1.0] * 11
    with pytest.raises(InputError, match=r"no output is called 'bdy\.\*'"):
        run(whole, results=path, variables=["bdy.*"])


def test_what_was_made_of_old_results_goes_with_them(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the first step, and not before; other files of the same name stay."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("m4e_fmi.cosim.results.writer.FLUSH", 0.0)
    names = ("r.nc", "r.csv", "r.png", "r.txt")
    seen: list[set[str]] = []

    def look(time: float, _: Network) -> None:
        seen.append({path.name for path in tmp_path.iterdir() if path.name in names})
        if time > 0.75:
            os.kill(os.getpid(), signal.SIGTERM)

    for name in names:
        Path(name).write_text("old")
    with pytest.raises(Terminated):
        run(oscillator(c_fmu, SHORT), results="r.csv", beside=[Path("r.png")], observers=[look])
    assert seen[0] == {*names}
    assert seen[-1] == {"r.nc", "r.txt"}
    assert load("r.nc").time[-1] == pytest.approx(0.8)
    assert Path("r.csv").read_text().startswith("time [s],")
    assert not Path("r.png").exists()


def test_results_tell_what_was_changed(c_fmu: Fmus, tmp_path: Path) -> None:
    """Start values and settings with who gave them: the last one counts, as it does in the run."""
    (tmp_path / "set.yaml").write_text("values: {body.body.m.x: 50 cm, body.body.m.vx: 2}\n")
    given = oscillator(c_fmu, SHORT)
    changed = given.changed(start=read_parameters(tmp_path / "set.yaml"))
    changed = changed.changed(algorithm="jacobi")
    start = {"body.body.m.vx": 3}
    changed = changed.changed(start=start, origin="command line", step_size=0.05)
    results = run(changed, results=tmp_path / "r.nc").results()
    told = results.attributes
    assert told["start_values"].splitlines() == ["body.body.m.x = 50 cm", "body.body.m.vx = 3"]
    assert told["changed"].splitlines() == [
        f"body.body.m.x = 50 cm ({tmp_path / 'set.yaml'})",
        "body.body.m.vx = 3 (command line)",
        "algorithm = jacobi (Python)",
        "step_size = 0.05 (command line)",
    ]
    assert "not as in the system's file (4): body.body.m.x = 50 cm" in repr(results)
    plain = run(given, results=tmp_path / "r.nc").results()
    assert plain.attributes["changed"] == ""
    assert "not as in" not in repr(plain)


def test_a_run_without_an_estimate_has_the_same_values_and_says_so(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    given = oscillator(c_fmu, Simulation(2, 0.01))
    whole = run(given, results=tmp_path / "r.nc").results()
    outcome = run(given, results=tmp_path / "r.nc", certify=False)
    reason = "it was not estimated, as asked (certify, --no-certify)"
    assert outcome.certificate == reason
    assert f"coupling error not known: {reason}" in run_text(outcome)
    found = outcome.results()
    assert found.attributes["coupling_error"] == f"not known: {reason}"
    assert "coupling_error_from" not in found.attributes
    assert all(np.array_equal(found[n].values, whole[n].values) for n in whole.series)
    with start(given, certify=False) as stepped:
        stepped.step()
    assert stepped.outcome.certificate == reason


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes")
def test_results_replace_no_pipe(c_fmu: Fmus, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "r.nc").symlink_to("pipe")
    with pytest.raises(InputError, match="replace no device or pipe"):
        run(oscillator(c_fmu, SHORT), results=tmp_path / "r.nc")
    assert (tmp_path / "pipe").is_fifo()
