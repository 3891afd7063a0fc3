"""Runs: results on disk, consistent starts, exact time, and failures that say what happened."""

from __future__ import annotations

import csv
import importlib
import os
import re
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest

from m4e_fmi.cli import main
from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Network,
    Simulation,
    System,
    load,
    load_system,
    prepare,
    read_parameters,
    run,
    save_system,
    start,
)
from m4e_fmi.cosim.error_estimate.report import Trace
from m4e_fmi.cosim.master.master import Observer
from m4e_fmi.cosim.results.writer import LEAST_ROWS
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.importer.unpack import Unpacked
from m4e_fmi.model import load_model
from m4e_fmi.program import Recorder, Variable
from m4e_fmi.report.text.summaries import run_summary
from m4e_fmi.signals import Terminated

Fmus = Callable[[str], Path]
Starts = Mapping[str, Mapping[str, float]]


def system(
    fmus: Fmus,
    components: Mapping[str, str],
    *connections: str,
    start: Starts | None = None,
    simulation: Simulation | None = None,
) -> System:
    parts = tuple(
        Component(name, FmuFile(fmus(model)), (start or {}).get(name, {}))
        for name, model in components.items()
    )
    return System("test", parts, connections, simulation or Simulation(1, 0.1))


def oscillator(fmus: Fmus, simulation: Simulation) -> System:
    """A mass of 1 kg on a spring of 1 N/m, released at rest at x = 1 m: x = cos t."""
    names = {"body": "mass", "spring": "spring"}
    start = {"body": {"body.m.x": 1.0}}
    return system(fmus, names, "body.m <-> spring.end", start=start, simulation=simulation)


@pytest.fixture(autouse=True)
def unpacking(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Every test unpacks into a folder of its own, which must be empty afterwards."""
    folder = tmp_path / "unpacked"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield
    assert not list(folder.iterdir())


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
    assert results.attributes["title"] == "test"
    assert results.attributes["algorithm"] == "corrector"
    assert results.attributes["step_size"] == "0.01 s"
    assert results.attributes["created"].endswith("+00:00")
    assert outcome.steps == 200


def test_more_rows_than_a_block_arrive_in_order(c_fmu: Fmus, tmp_path: Path) -> None:
    outcome = run(oscillator(c_fmu, Simulation(7, 0.01)), results=tmp_path / "r.nc")
    results = outcome.results()
    assert len(results.time) == 701
    assert np.all(np.diff(results.time) > 0)
    np.testing.assert_allclose(results["body.body.m.x"].values, np.cos(results.time), atol=1e-4)


def test_time_never_drifts(c_fmu: Fmus) -> None:
    seen: list[float] = []
    settings = Simulation(1000, 0.1)
    alone = system(c_fmu, {"clock": "rogue"}, simulation=settings)
    outcome = run(alone, observers=[lambda t, _: seen.append(t)])
    assert outcome.steps == 10_000
    assert seen[-1] == 1000.0
    assert seen == [k / 10 for k in range(10_001)]


def test_the_last_step_is_shortened_to_the_stop_time(c_fmu: Fmus) -> None:
    seen: list[float] = []
    values: list[float] = []

    def observe(t: float, network: Network) -> None:
        seen.append(t)
        values.append(network.read("body.body.m.x"))

    run(oscillator(c_fmu, Simulation(1.025, 0.01)), observers=[observe])
    assert seen[-2:] == [1.02, 1.025]
    assert values[-1] == pytest.approx(np.cos(1.025), abs=2e-5)  # H²/12 and phase, as above


def test_feed_through_is_fresh_and_consistent_from_the_start(c_fmu: Fmus) -> None:
    # y = gain u + t in a row of three, listed against the flow
    names = {"third": "stage", "second": "stage", "first": "stage"}
    chain = ("first.y -> second.u", "second.y -> third.u")
    start = {"first": {"gain": 2.0, "u": 5.0}, "second": {"gain": 3.0}, "third": {"gain": 4.0}}
    for algorithm in ("jacobi", "gauss_seidel"):
        seen: dict[float, float] = {}

        def observe(t: float, network: Network, seen: dict[float, float] = seen) -> None:
            seen[t] = network.read("third.y")

        settings = Simulation(0.2, 0.1, algorithm=algorithm)
        run(
            system(c_fmu, names, *chain, start=start, simulation=settings),
            observers=[observe],
        )
        # ((2·5 + t)·3 + t)·4 + t at the same instant everywhere
        expected = {t: ((10 + t) * 3 + t) * 4 + t for t in (0.0, 0.1, 0.2)}
        assert seen == pytest.approx(expected, abs=1e-12)


def test_calculated_parameters_reach_parameters_in_order(c_fmu: Fmus) -> None:
    names = {"c": "stage", "b": "stage", "a": "stage"}
    links = ("a.twice -> b.gain", "b.twice -> c.gain", "a.y -> c.u")
    start = {"a": {"gain": 3.0, "u": 7.0}}
    read: dict[str, float] = {}

    def observe(t: float, network: Network) -> None:
        if t == 0.0:
            read.update(gain=network.read("c.gain"), y=network.read("c.y"))

    run(system(c_fmu, names, *links, start=start), observers=[observe])
    assert read == {"gain": 12.0, "y": 12.0 * 21.0}


ALGORITHM_NAMES = ("jacobi", "gauss_seidel", "corrector", "implicit")


@pytest.mark.parametrize("algorithm", ALGORITHM_NAMES)
@pytest.mark.parametrize(
    ("what", "told"), [(2, "Discard"), (3, "Error"), (4, "Fatal"), (8, "inf"), (9, "nan")]
)
def test_a_failing_component_is_named_and_results_kept(
    c_fmu: Fmus, tmp_path: Path, what: int, told: str, algorithm: str
) -> None:
    path = tmp_path / "r.nc"
    start = {"pump": {"what": float(what), "when": 0.5}}
    names = {"body": "mass+state", "pump": "rogue+state", "next": "stage+state"}
    # one bond for the corrector to correct
    names["spring"] = "spring+state"
    links = ("pump.y -> next.u", "body.m <-> spring.end")
    settings = Simulation(1, 0.1, algorithm)
    with pytest.raises(RunError) as caught:
        run(system(c_fmu, names, *links, start=start, simulation=settings), results=path)
    message = caught.value.message
    assert "pump" in message
    assert told in message
    assert re.search(r"t = 0\.(4|425|45|475|5) s", message)
    if what < 5:
        assert "the pump ran dry" in message
    assert ("step_size" in caught.value.remedy) == (what not in (3, 4))
    assert caught.value.remedy.startswith("the FMU tells why: see to that first") == (what < 5)
    results = load(path)
    assert f"results until t = {results.time[-1]:.9g} s are in {path}" in caught.value.remedy
    # where all can go back, a discarded step is made again up to where the FMU can go
    goes_on = what == 2 and algorithm in ("corrector", "implicit")
    assert ("; pump has discarded every step from there, of 0.1 s down to" in message) is goes_on
    assert ("no step_size helps: look at what pump" in caught.value.remedy) is goes_on
    begin, end = re.findall(r"t = (\S+) s(?: to (\S+) s)?", message)[0]
    assert begin != end
    assert results.time[-1] == pytest.approx(0.5 if goes_on else 0.4, abs=1e-6)
    np.testing.assert_allclose(results.time[:5], [0, 0.1, 0.2, 0.3, 0.4], atol=1e-15)
    assert all(np.isfinite(s.values).all() for g in results.components.values() for s in g.values())
    assert results.attributes["ended"] == f"failed: {message}"


@pytest.mark.parametrize(("longest", "creeps"), [(5e-4, False), (2e-5, True)])
def test_a_run_that_creeps_ends(c_fmu: Fmus, longest: float, creeps: bool) -> None:
    """The FMU discards steps longer than that: where steps of a thousandth of those of the system
    are discarded again and again, the run would go on without end."""
    names = {"pump": "rogue+state", "next": "stage+state"}
    start = {"pump": {"what": 5.0, "when": longest}}
    settings = Simulation(0.2, 0.1)
    parts = system(c_fmu, names, "pump.y -> next.u", start=start, simulation=settings)
    if not creeps:
        assert run(parts).steps > 0.1 / longest  # each is made in halves
        return
    with pytest.raises(RunError) as caught:
        run(parts)
    assert re.search(
        r"pump has discarded 128 steps since t = 0 s, of 0\.1 s down to", caught.value.message
    )
    assert "no step_size helps: look at what pump" in caught.value.remedy


def test_an_output_that_is_only_recorded_is_checked_too(c_fmu: Fmus, tmp_path: Path) -> None:
    start = {"pump": {"what": 9.0, "when": 0.5}}
    with pytest.raises(RunError, match=r"pump\.y at t = 0\.5 s is nan"):
        run(system(c_fmu, {"pump": "rogue"}, start=start), results=tmp_path / "r.nc")
    assert load(tmp_path / "r.nc").time[-1] == pytest.approx(0.4)


def test_a_tolerance_that_is_missed_ends_the_run(c_fmu: Fmus, tmp_path: Path) -> None:
    """y'' = 1e24 y: no step is small enough for it."""
    names = {"a": "integrator+state", "b": "integrator+state"}
    start = {"a": {"y": 1.0, "gain": 1e12}, "b": {"gain": 1e12}}
    settings = Simulation(2, 0.1, "corrector", start_time=1.0, coupling_tolerance=1e-4)
    with pytest.raises(RunError) as caught:
        run(
            system(c_fmu, names, "a.y -> b.u", "b.y -> a.u", start=start, simulation=settings),
            results=tmp_path / "r.nc",
        )
    assert "stays above coupling_tolerance" in caught.value.message
    assert "leave coupling_tolerance out" in caught.value.remedy
    results = load(tmp_path / "r.nc")
    assert f"results until t = {results.time[-1]:.9g} s" in caught.value.remedy


def test_a_loop_without_solution_ends_the_run(c_fmu: Fmus, tmp_path: Path) -> None:
    """a.y = a.u + t, b.y = b.u + t in a ring: 0 = 2 t, which holds at the start only."""
    names = {"a": "stage+state", "b": "stage+state"}
    settings = Simulation(1, 0.1, "implicit")
    loop = system(c_fmu, names, "a.y -> b.u", "b.y -> a.u", simulation=settings)
    with pytest.raises(RunError) as caught:
        run(loop, results=tmp_path / "r.nc")
    assert re.search(r"[ab]\.u", caught.value.message)
    assert "t = 0 s" in caught.value.message or "t = 0.1 s" in caught.value.message
    assert "results until t = 0 s" in caught.value.remedy
    assert load(tmp_path / "r.nc").time.tolist() == [0.0]


def test_a_run_that_ends_well_says_so(c_fmu: Fmus, tmp_path: Path) -> None:
    outcome = run(oscillator(c_fmu, Simulation(1, 0.1)), results=tmp_path / "r.nc")
    assert outcome.results().attributes["ended"] == "at the stop time"


def test_an_end_in_the_first_step_replaces_the_results_of_before(
    c_fmu: Fmus, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, picture = tmp_path / "r.nc", tmp_path / "r.png"
    fuse = system(c_fmu, {"fuse": "ending"}, start={"fuse": {"when": 0.5, "y": 3.0}})
    assert len(run(fuse, results=file).results().time) == 6
    path = save_system(fuse.changed(start={"fuse.when": 0.0}), tmp_path / "s.ssp")
    picture.write_bytes(b"old")
    assert main(["run", str(path), "--output-file", str(file)]) == 0
    told = capsys.readouterr()
    assert "warning: the run ended before its first step" in told.err
    assert "in PythonFMU, do_step must return True" in told.err
    assert told.err.count("warning: ") == 1
    assert "warning" not in told.out
    results = load(file)
    assert results.time.tolist() == [0.0]
    assert results["fuse.y"].values.tolist() == [3.0]
    assert "asked for the end of the simulation at t = 0 s" in results.attributes["ended"]
    assert picture.read_bytes() != b"old"


def test_a_stepped_run_without_a_step_has_its_own_results(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "r.nc"
    fuse = system(c_fmu, {"fuse": "ending"})
    run(fuse, results=file)
    with start(fuse.changed(start={"fuse.y": 3.0}), results=file) as stepped:
        pass
    assert stepped.outcome.results()["fuse.y"].values.tolist() == [3.0]


def test_results_that_fill_their_blocks_are_complete(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("m4e_fmi.cosim.results.writer.MOST_ROWS", LEAST_ROWS)
    steps = 2 * LEAST_ROWS - 1
    settings = Simulation(steps / 10, 0.1)
    outcome = run(system(c_fmu, {"a": "rogue"}, simulation=settings), results=tmp_path / "r.nc")
    assert len(outcome.results().time) == 2 * LEAST_ROWS
    assert outcome.results().attributes["ended"] == "at the stop time"


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
    assert "of netCDF's classic form" in outcome.notes[-1]
    found = outcome.results().attributes
    assert {"coupling_error", "messages", "ended"} <= set(found)
    created = {"created": ""}
    assert {**found, **created} == {**whole.attributes, **created}
    assert list(outcome.results().series) == list(whole.series)


def test_chosen_variables_are_recorded(c_fmu: Fmus, tmp_path: Path) -> None:
    path = tmp_path / "r.nc"
    whole = oscillator(c_fmu, Simulation(1, 0.1))
    chosen = run(whole, results=path, variables=["body.*x", "spring.stiffness"]).results()
    names = {f"{c}.{n}" for c, members in chosen.components.items() for n in members}
    assert names == {"body.body.m.x", "body.body.m.vx", "body.body.m.ax", "spring.stiffness"}
    assert chosen["spring.stiffness"].values.tolist() == [1.0] * 11
    with pytest.raises(InputError, match=r"no output is called 'bdy\.\*'"):
        run(whole, results=path, variables=["bdy.*"])


def test_results_as_csv(c_fmu: Fmus, tmp_path: Path) -> None:
    results = run(oscillator(c_fmu, Simulation(1, 0.1)), results=tmp_path / "r.csv").results()
    with (tmp_path / "r.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows[0][:2] == ["time [s]", "body.body.m.x [m]"]
    assert [float(row[1]) for row in rows[1:]] == results["body.body.m.x"].values.tolist()


def test_results_as_parquet(c_fmu: Fmus, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "r.parquet"
    results = run(oscillator(c_fmu, Simulation(1, 0.1)), results=path).results()
    series = {
        f"{c}.{n}": s for c, members in results.components.items() for n, s in members.items()
    }
    frame = pandas.read_parquet(path)
    assert list(frame) == ["time", *series]
    np.testing.assert_array_equal(frame["time"], results.time)
    schema = parquet.read_schema(path)
    for name, one in series.items():
        np.testing.assert_array_equal(frame[name], one.values)
        metadata = schema.field(name).metadata
        assert metadata[b"unit"].decode() == one.unit
        assert metadata[b"long_name"].decode() == one.long_name
    assert schema.field("time").metadata[b"unit"] == b"s"
    told = {key.decode(): value.decode() for key, value in schema.metadata.items()}
    assert results.attributes.items() <= told.items()


def test_a_failed_run_is_in_parquet_too(c_fmu: Fmus, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "r.parquet"
    start = {"pump": {"what": 9.0, "when": 0.5}}
    with pytest.raises(RunError, match=re.escape(str(path))):
        run(system(c_fmu, {"pump": "rogue"}, start=start), results=path)
    table = parquet.read_table(path)
    assert table["time"].to_pylist() == load(path.with_suffix(".nc")).time.tolist()
    assert table.schema.metadata[b"ended"].startswith(b"failed: pump.y at t = 0.5 s is nan")


def test_parquet_without_its_package(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(InputError, match="needs the package pyarrow"):
        run(oscillator(c_fmu, Simulation(1, 0.1)), results=tmp_path / "r.parquet")


@pytest.mark.parametrize("name", ["r.png", "r.xlsx", "r"])
def test_results_in_an_unknown_form(c_fmu, tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"use \.nc, \.csv or \.parquet"):
        run(oscillator(c_fmu, Simulation(1, 0.1)), results=tmp_path / name)
    assert not (tmp_path / name).exists()
    assert not list(tmp_path.glob("r.*"))


def test_fmus_are_unpacked_below_a_plain_path(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    strange = tmp_path / "Ünser Ordner #1"
    strange.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(strange))
    unpacked = Unpacked(c_fmu("mass"))
    assert re.fullmatch(r"[A-Za-z0-9_./\\:-]+", str(unpacked.folder))
    assert (unpacked.folder / "modelDescription.xml").is_file()
    unpacked.remove()
    assert not unpacked.folder.exists()


def test_a_start_value_of_the_wrong_type_is_refused(c_fmu: Fmus) -> None:
    wrong = System(
        "test",
        (Component("body", FmuFile(c_fmu("mass")), {"mass": "heavy"}),),
        (),
        Simulation(1, 0.1),
    )
    with pytest.raises(
        InputError, match=r"'heavy' of body\.mass is wrong\n +'heavy' is not a number"
    ):
        run(wrong)


@pytest.mark.parametrize("value", ["nan N", float("nan"), float("-inf")])
def test_numbers_that_are_not_finite_are_refused_where_they_are_given(
    c_fmu: Fmus, value: str | float
) -> None:
    given = oscillator(c_fmu, Simulation(1, 0.1))
    wrong = given.changed(start={"body.body.m.force_x": value}, origin="command line")
    with pytest.raises(InputError, match=r"command line: start value .* is wrong") as caught:
        prepare(wrong)
    assert caught.value.problems[0].remedy == "give a finite number"
    with start(given) as stepped, pytest.raises(InputError, match="give a finite number"):
        stepped["body.damping"] = value if isinstance(value, float) else "nan N.s/m"
    if isinstance(value, float):
        with pytest.raises(InputError, match=r"command line: output_interval .*expected"):
            given.changed(output_interval=value, origin="command line")


def test_progress_tells_simulated_time(c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("m4e_fmi.cosim.master.ticking.PROGRESS_INTERVAL", 0.0)
    told: list[float] = []
    run(oscillator(c_fmu, Simulation(1, 0.1)), progress=told.append)
    assert told == [k / 10 for k in range(1, 11)]


def test_ctrl_c_stops_at_a_communication_point(c_fmu: Fmus, tmp_path: Path) -> None:
    def observe(t: float, _: Network) -> None:
        if t == 0.5:
            os.kill(os.getpid(), signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)  # ignored where tests run in the background
    system, path = oscillator(c_fmu, Simulation(1, 0.1)), tmp_path / "r.nc"
    with pytest.raises(KeyboardInterrupt) as caught:
        run(system, results=path, observers=[observe])
    assert caught.value.__notes__ == [
        "at t = 0.5 s of 1 s", f"results until t = 0.5 s are in {path} (6 rows)"
    ]  # fmt: skip
    assert load(path).time[-1] == 0.5
    with pytest.raises(KeyboardInterrupt) as caught:
        run(system, observers=[observe])
    assert caught.value.__notes__ == ["at t = 0.5 s of 1 s"]
    assert signal.getsignal(signal.SIGINT) is before


def test_signals_stop_at_a_communication_point_unless_ignored(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def send(number: signal.Signals) -> Observer:
        return lambda t, _: os.kill(os.getpid(), number) if t == 0.5 else None

    short = oscillator(c_fmu, Simulation(1, 0.1))
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(Terminated) as caught:
        run(short, results=tmp_path / "r.nc", observers=[send(signal.SIGTERM)])
    assert caught.value.code == 128 + signal.SIGTERM
    assert signal.getsignal(signal.SIGTERM) is before is signal.SIG_DFL
    results = load(tmp_path / "r.nc")
    assert (results.time[-1], results.attributes["ended"]) == (0.5, "ended by SIGTERM")
    last: list[Observer] = [lambda t, _: os.kill(os.getpid(), signal.SIGTERM) if t == 1 else None]
    with pytest.raises(Terminated) as caught:
        run(short, results=tmp_path / "r.nc", observers=last)
    assert caught.value.__notes__[0] == "at the stop time, t = 1 s"
    assert "(11 rows)" in caught.value.__notes__[1]
    assert load(tmp_path / "r.nc").attributes["ended"] == "at the stop time"
    second = iter([False, True])

    def in_second_run(t: float, _: Network) -> None:
        if t == 0.5 and next(second):
            os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(Trace, "__call__", lambda _, t, network: in_second_run(t, network))
    with pytest.raises(Terminated) as caught:
        run(short, results=tmp_path / "r.nc", check=True)
    assert caught.value.__notes__ == [
        "at t = 0.5 s of 1 s",
        "that was the second run, at half the step",
        f"the results of the first are complete, in {tmp_path / 'r.nc'}",
    ]
    if hasattr(signal, "SIGHUP"):
        usual = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
        try:
            outcome = run(short, results=tmp_path / "r.nc", observers=[send(signal.SIGHUP)])
        finally:
            signal.signal(signal.SIGHUP, usual)
        assert outcome.results().time[-1] == 1.0


KEPT = "results until t = 1 s are in r.csv (11 rows)"
NOT_YET = "the results are complete in r.nc (11 rows); r.csv is not written"
ENDS = {  # what is called at the end of a run, and what is said if SIGTERM comes just before it
    "cosim.results.writer:ResultsWriter.close": KEPT,
    "cosim.results.writer:ResultsWriter._flush": KEPT,
    "cosim.master.run:closing_attributes": KEPT,
    "cosim.results.writer:write_netcdf": KEPT,
    "cosim.master.run:Outcome": NOT_YET,
    "cosim.master.recording:export": NOT_YET,
    "files.temporary:_leave": "the results are complete in r.csv (11 rows)",
}


@pytest.mark.parametrize(("where", "says"), ENDS.items(), ids=ENDS)
def test_a_signal_after_the_last_step_loses_no_row(
    where: str, says: str, c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    ready = prepare(oscillator(c_fmu, Simulation(1, 0.1)))
    module, _, path = where.partition(":")
    owner: Any = importlib.import_module(f"m4e_fmi.{module}")
    *parents, name = path.split(".")
    for parent in parents:
        owner = getattr(owner, parent)
    known, sent = getattr(owner, name), []

    def send(*arguments: Any, **options: Any) -> Any:
        if not sent:
            sent.append(True)
            signal.raise_signal(signal.SIGTERM)
        return known(*arguments, **options)

    monkeypatch.setattr(owner, name, send)
    with pytest.raises(Terminated) as caught:
        run(ready, results="r.csv")
    assert sent
    assert caught.value.__notes__ == ["at the stop time, t = 1 s", says]
    results = load("r.nc")
    assert results.time.tolist() == pytest.approx(np.arange(11) / 10)
    assert results.attributes["ended"] == "at the stop time"


def test_what_was_made_of_old_results_goes_with_them(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the first step, and not before; other files of the same name stay."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("m4e_fmi.cosim.results.writer.FLUSH", 0.0)
    names = ("r.nc", "r.csv", "r.png", "r.parquet")
    seen: list[set[str]] = []

    def look(time: float, _: Network) -> None:
        seen.append({path.name for path in tmp_path.iterdir() if path.name in names})
        if time > 0.75:
            os.kill(os.getpid(), signal.SIGTERM)

    for name in names:
        Path(name).write_text("old")
    system = oscillator(c_fmu, Simulation(1, 0.1))
    with pytest.raises(Terminated):
        run(system, results="r.csv", beside=[Path("r.png")], observers=[look])
    assert seen[0] == {*names}
    assert seen[-1] == {"r.nc", "r.parquet"}
    assert load("r.nc").time[-1] == pytest.approx(0.8)
    assert Path("r.csv").read_text().startswith("time [s],")
    assert not Path("r.png").exists()


@pytest.mark.skipif(os.name == "nt", reason="open files keep their folder there")
def test_a_folder_that_is_renamed_during_the_run(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All of the results are in one place, and it is said where."""
    monkeypatch.setattr("m4e_fmi.cosim.results.writer.FLUSH", 0.0)
    folder, other = tmp_path / "folder", tmp_path / "other"
    folder.mkdir()
    monkeypatch.chdir(folder)

    def rename(time: float, _: Network) -> None:
        if time == 0.5:
            folder.rename(other)

    ready = prepare(oscillator(c_fmu, Simulation(1, 0.1)))
    outcome = run(ready, results="r.csv", observers=[rename])
    assert outcome.path == folder / "r.nc"
    assert len(outcome.results().time) == 11
    assert {path.name for path in folder.iterdir()} == {"r.nc", "r.csv"}
    assert f"warning: {folder} was renamed or removed during the run" in run_summary(outcome)


@pytest.mark.parametrize(("step", "warned"), [(0.01, False), (0.4, True)])
def test_a_coupling_that_is_all_wrong_is_warned_of(
    c_fmu: Fmus, tmp_path: Path, step: float, *, warned: bool
) -> None:
    a = Component("a", FmuFile(c_fmu("mass+state")), {"body.m.x": 1.0})
    b = Component("b", FmuFile(c_fmu("partner+state")), {"coupling": 10.0})
    settings = Simulation(10.0, step, "gauss_seidel" if step < 0.1 else "jacobi")
    told: list[str] = []
    system = System("s", (a, b), ("a.m <-> b.end",), settings)
    outcome = run(system, results=tmp_path / "r.nc", warn=told.append)
    notes = outcome.results().attributes.get("notes", "")
    for text in (run_summary(outcome), "\n".join(outcome.warnings), "\n".join(told), notes):
        assert ("that is no result" in text) == warned


def test_results_tell_what_was_changed(c_fmu: Fmus, tmp_path: Path) -> None:
    """Start values and settings with who gave them: the last one counts, as it does in the run."""
    (tmp_path / "set.yaml").write_text("values: {body.body.m.x: 50 cm, body.body.m.vx: 2}\n")
    given = oscillator(c_fmu, Simulation(1, 0.1))
    values = read_parameters(tmp_path / "set.yaml")
    changed = given.changed(start=values).changed(algorithm="jacobi")
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


def test_what_was_given_wrong_is_told_where_it_was_given(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "set.yaml"
    file.write_text("values:\n  body.body.m.y: 1\n  bdy.x: 2\n  body: 3\n")
    given = oscillator(c_fmu, Simulation(1, 0.1))
    with pytest.raises(InputError) as caught:
        given.changed(start=read_parameters(file))
    (first, second) = caught.value.problems
    assert str(first).startswith(f"{file}:3:3: start value 'bdy.x': there is no component 'bdy'")
    assert "did you mean 'body'?" in first.remedy
    assert "expected COMPONENT.VARIABLE" in second.message
    file.write_text("values:\n  body.body.m.y: 1\n")
    both = given.changed(start=read_parameters(file))
    both = both.changed(start={"body.body.m.xx": 1}, origin="command line")
    with pytest.raises(InputError) as caught:
        prepare(both)
    texts = [str(problem) for problem in caught.value.problems]
    assert texts[0].startswith(f"{file}:2:3: 'body' has no variable 'body.m.y'")
    assert texts[1].startswith("command line: 'body' has no variable 'body.m.xx'")
    assert "did you mean 'body.m.x'?" in texts[1]
    with pytest.raises(InputError) as caught:
        given.changed(start={"bdy.x": 1}, origin="command line", stop_time=-1.0)
    assert [problem.file for problem in caught.value.problems] == ["command line"] * 2


def test_a_run_without_columns_says_so(tmp_path: Path) -> None:
    recorder = Recorder("silent", "")
    recorder.parameter(Variable("m", "kg", "nobody reads it", start=1.0))
    part = Component("a", FmuFile(build_fmu(recorder.program(), tmp_path / "silent.fmu")))
    told: list[str] = []
    path = tmp_path / "r.nc"
    outcome = run(System("s", (part,), (), Simulation(1, 0.1)), results=path, tell=told.append)
    assert [line[:38] for line in told] == ["the results have no column but time: t"]
    assert told[0] in run_summary(outcome)


def test_a_system_may_be_given_by_its_path(c_fmu: Fmus, tmp_path: Path) -> None:
    package = save_system(oscillator(c_fmu, Simulation(1, 0.1)), tmp_path / "s.ssp")
    expected = run(load_system(package)).steps
    build = tmp_path / "b"
    assert run(package, build_directory=build).steps == expected
    with start(str(package), build_directory=build) as stepped:
        assert len(list(stepped)) == expected + 1
    for wrong in (42, None, b"s.ssp", load_model):
        for verb in (run, prepare):
            with pytest.raises(InputError, match="expected a System, or the path of a system"):
                verb(wrong)  # pyright: ignore[reportArgumentType]
