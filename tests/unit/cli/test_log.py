"""Where lines of a command go: --quiet, --events, and the progress bar."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from argparse import Namespace
from pathlib import Path

import pytest
from support.command_line import EXAMPLES, FLEXIBLE, PENDULUM, copied, refused

from m4e_fmi.cli import main
from m4e_fmi.cli.shared import log
from m4e_fmi.cli.shared.log import EVENTS

PAGE = EXAMPLES.parent / "docs" / "logs.md"
SIMULATE = ["simulate", PENDULUM, "--stop-time", "0.5", "--no-plot"]
FIELDS = {kind: {"event", "wall_time", *fields} for kind, fields in EVENTS.items()}


def called(*words: object) -> int:
    return main([str(word) for word in words])


def events(capsys: pytest.CaptureFixture) -> list[dict]:
    """The events on the standard output: nothing else is there, and each has its fields."""
    found = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    for event in found:
        assert set(event) == FIELDS[event["event"]]
    assert (found[0]["event"], found[-1]["event"]) == ("start", "end")
    walls = [event["wall_time"] for event in found]
    assert walls == sorted(walls)
    return found


def one(found: list[dict], kind: str) -> dict:
    (event,) = [event for event in found if event["event"] == kind]
    return event


@pytest.fixture
def system(here: Path) -> Path:
    copied(here, FLEXIBLE / "mass.model.yaml")
    return copied(here, FLEXIBLE / "system.yaml")


def test_a_run_tells_its_events(system, capsys):
    options = ["--stop-time", "0.2", "--no-plot"]
    assert called("run", system, "--events", *options) == 0
    found = events(capsys)
    kinds = [event["event"] for event in found]
    assert kinds.index("plan") < kinds.index("line") < kinds.index("summary") < kinds.index("file")
    plan, summary = one(found, "plan"), one(found, "summary")
    assert (plan["components"], plan["stop_time"]) == (["body", "line"], 0.2)
    numbers = {number["name"]: number for number in summary["numbers"]}
    assert numbers["simulated time"] == {"name": "simulated time", "unit": "s", "value": 0.2}
    height = next(v for v in summary["variables"] if v["name"] == "body.body.mass.z")
    assert height["unit"] == "m"
    assert height["min"] < height["mean"] < height["max"]
    assert one(found, "file")["path"] == str(Path("build", "flexible_pendulum.nc"))


def test_an_error_is_told_with_its_place(here, capsys):
    copied(here, PENDULUM, ("mass: m, inertia: J}", "mas: m, inertia: J}"))
    assert called("simulate", PENDULUM.name, "--events") == 2
    captured = capsys.readouterr()
    found = [json.loads(line) for line in captured.out.splitlines()]
    error = one(found, "error")
    assert error["kind"] == "input"
    assert {p["file"] for p in error["problems"]} == {PENDULUM.name}
    lines = (here / PENDULUM.name).read_text().splitlines()
    assert "mas: m" in lines[error["problems"][0]["line"] - 1]
    assert error["text"] in captured.err
    assert one(found, "end")["exit_code"] == 2


def test_quiet_leaves_warnings_and_errors(system, capsys):
    assert called("run", system, "--stop-time", "0.2", "--quiet") == 0
    out, err = capsys.readouterr()
    assert out == ""
    (line,) = err.splitlines()  # of the FMU
    assert line.startswith("line, warning at t = 0 s: anchor pivot")
    assert Path("build", "flexible_pendulum.nc").is_file()
    assert "no such file" in refused(capsys, "run", "none.yaml", "--quiet")


@pytest.mark.usefixtures("here")
def test_texts_that_act_on_a_terminal_reach_no_program(capsys):
    with log.logged(Namespace(events=True), ["run", "\x1b[2J"]):
        log.say("evil \x1b]0;title\x07 \u202e line\nnext")
        log.show("two\nlines \x1b[1m")
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert all("\x1b" not in e.get("text", "") for e in told)


@pytest.mark.usefixtures("here")
def test_progress_is_told_in_events(capsys):
    assert called(*SIMULATE, "--events") == 0
    told = [e for e in events(capsys) if e["event"] == "progress"]
    assert told
    assert all(0.0 <= e["fraction"] <= 1.0 for e in told)


def test_the_page_names_every_field():
    text = PAGE.read_text("utf-8")
    for kind, fields in EVENTS.items():
        (row,) = [line for line in text.splitlines() if line.startswith(f"| `{kind}` |")]
        assert set(fields) <= set(re.findall(r"`(\w+)`", row)), kind


def test_what_code_of_users_prints_is_no_event(tmp_path):
    """It goes to the standard error, from Python and from libraries."""
    (tmp_path / "talk.py").write_text(
        "import os\n"
        "print('read')\n"
        "class Talk:\n"
        "    outputs = {'y': 'm'}\n"
        "    def step(self, t, h, v):\n"
        "        print('stepped')\n"
        "        os.write(1, b'by a library\\n')\n"
        "        return {'y': t}\n",
        encoding="utf-8",
    )
    (tmp_path / "talk.yaml").write_text(
        "name: talk\n"
        "components: {talk: {kind: python, file: talk.py}}\n"
        "simulation: {stop_time: 0.2, step_size: 0.1}\n",
        encoding="utf-8",
    )
    command = [sys.executable, "-m", "m4e_fmi", "run", "talk.yaml", "--events"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    found = [json.loads(line)["event"] for line in done.stdout.splitlines()]
    assert (found[0], found[-1]) == ("start", "end")
    for text in ("read", "stepped", "by a library"):
        assert text in done.stderr
