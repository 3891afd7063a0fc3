"""Signals that come while an FMU written in Python is called: they end the run, not the FMU."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from pythonfmu import FmuBuilder

from m4e_fmi.cli import main

SLAVE = '''\
"""Sends its process a signal where it is told, in the instance that it is told."""
import os
import signal

from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Sender(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u = self.y = 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))
        self.instance = int(os.environ.get("SENDER_INSTANCES", "0")) + 1
        os.environ["SENDER_INSTANCES"] = str(self.instance)
        self.send("init")

    def setup_experiment(self, *times):
        self.send("setup")

    def exit_initialization_mode(self):
        self.send("exit")

    def do_step(self, t, h):
        self.y += h * self.u
        self.send("step")
        return True

    def terminate(self):
        self.send("terminate")

    def send(self, where):
        if os.environ.get("SENDER_WHERE") != f"{where} {self.instance}":
            return
        os.environ["SENDER_SENT"] = "1"
        try:
            signal.raise_signal(int(os.environ["SENDER_SIGNAL"]))
        except BaseException:
            if os.environ["SENDER_EATS"] == "0":
                raise
'''


@pytest.fixture(scope="module")
def sender(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sender")
    (folder / "sender.py").write_text(SLAVE)
    FmuBuilder.build_FMU(folder / "sender.py", dest=folder)
    return folder / "Sender.fmu"


@pytest.fixture
def heard() -> Iterator[None]:
    """Ctrl-C is not ignored, as it may be where tests run in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heard")
@pytest.mark.parametrize(
    ("where", "number", "eats"),
    [
        ("init 1", signal.SIGTERM, False),
        ("setup 1", signal.SIGINT, False),
        ("setup 1", signal.SIGTERM, True),
        ("exit 1", signal.SIGTERM, False),
        ("step 1", signal.SIGINT, True),
        ("terminate 1", signal.SIGTERM, False),
        ("init 4", signal.SIGINT, False),
        ("setup 4", signal.SIGTERM, False),
        ("exit 4", signal.SIGINT, True),
        ("terminate 4", signal.SIGTERM, False),
    ],
)
def test_a_signal_ends_the_run(
    where: str,
    number: signal.Signals,
    eats: bool,
    sender: Path,
    c_fmu: Callable[[str], Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Instances 1 to 3 are probed, the fourth is that of the run; one may eat exceptions."""
    (tmp_path / "system.yaml").write_text(
        f"name: s\ncomponents:\n  a: {{fmu: {c_fmu('integrator')}}}\n"
        f"  b: {{fmu: {sender}, process: here}}\n"
        "connections: ['a.y -> b.u, units ignored', 'b.y -> a.u, units ignored']\n"
        "simulation: {stop_time: 1, step_size: 0.1}\n"
    )
    for name, value in (("WHERE", where), ("SIGNAL", int(number)), ("EATS", int(eats))):
        monkeypatch.setenv(f"SENDER_{name}", str(value))
    monkeypatch.setenv("SENDER_INSTANCES", "0")
    monkeypatch.setenv("SENDER_SENT", "0")
    code = main(["run", str(tmp_path / "system.yaml"), "--output-file", str(tmp_path / "r.nc")])
    assert code == 128 + number
    error = capsys.readouterr().err
    told = "interrupted" if number == signal.SIGINT else "ended by SIGTERM"
    assert [line for line in error.splitlines() if line][-1].startswith(told)
    assert "failed" not in error
    assert "fatal" not in error
