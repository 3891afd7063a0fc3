"""Which components run in processes of their own, and under which limits."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, load_system, prepare
from m4e_fmi.errors import InputError
from m4e_fmi.fmu.importer.worker import Host

Fmus = Callable[[str], Path]
SYSTEM = """name: s
components:
  a: {{fmu: {fmu}{keys}}}
simulation: {{stop_time: 1, step_size: 0.1}}
{more}
"""


@pytest.fixture
def stranger(c_fmu: Fmus, tmp_path: Path) -> Path:
    """A copy of an FMU, without the record that says that it was built here."""
    return Path(shutil.copy(c_fmu("mass+state"), tmp_path / "stranger.fmu"))


def of(*components: Component) -> System:
    return System("s", components, (), Simulation(1.0, 0.1))


def test_strangers_and_who_asks_for_it_have_processes(c_fmu: Fmus, stranger: Path) -> None:
    own = FmuFile(c_fmu("mass+state"))
    prepared = prepare(
        of(
            Component("own", own),
            Component("other", FmuFile(stranger)),
            Component("asked", own, process="own"),
            Component("trusted", FmuFile(stranger), process="here"),
        )
    )
    assert dict(prepared.hosts) == {"other": Host(), "asked": Host()}
    assert "in processes of their own: other, asked" in str(prepared)


def test_a_record_of_another_content_counts_for_nothing(c_fmu: Fmus, stranger: Path) -> None:
    record = c_fmu("spring+state").with_name("spring_state.build.json")
    shutil.copy(record, stranger.with_name("stranger.build.json"))
    assert prepare(of(Component("other", FmuFile(stranger)))).hosts.keys() == {"other"}


def test_keys_of_system_files(stranger: Path, tmp_path: Path) -> None:
    more = "limits: {call: 500 ms, end: 2 s}\nenvironment: {keep: [LICENSE]}"
    file = tmp_path / "s.yaml"
    file.write_text(SYSTEM.format(fmu=stranger, keys="", more=more))
    found = prepare(load_system(file)).hosts["a"]
    assert found == Host(0.5, 2.0, keep=("LICENSE",))


def test_without_fork_a_stranger_runs_here_and_a_request_is_refused(
    stranger: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on Windows, where nothing else starts such processes."""
    monkeypatch.delattr("os.fork")
    prepared = prepare(of(Component("other", FmuFile(stranger))))
    assert not prepared.hosts
    assert "other: run in this process" in "\n".join(prepared.warnings)
    file = tmp_path / "s.yaml"
    text = SYSTEM.format(fmu=stranger, keys=", process: own", more="limits: {end: 2 s}")
    file.write_text(text)
    with pytest.raises(InputError, match="no FMU can have a process of its own") as failure:
        prepare(load_system(file))
    assert [problem.remedy for problem in failure.value.problems] == 2 * [
        "leave this out, or run the system on another machine"
    ]
    assert f"{file}:3:" in str(failure.value)
    assert f"{file}:5:" in str(failure.value)
