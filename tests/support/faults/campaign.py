"""Random cases of the campaign of faults, and the check of one: run, look, resume, look again."""

from __future__ import annotations

import random
import re
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from support.faults.build import build_faulty
from support.faults.table import BYTES, CLOSING, KINDS, NAMES, RUNNING, STATES, Fault
from support.faults.trial import (
    CHECKPOINTS,
    COMPONENTS,
    STEP,
    STOP,
    Done,
    Place,
    differences,
    write_system,
)

from m4e_fmi.results.results_file import Results

ALGORITHMS = ("jacobi", "gauss_seidel", "corrector", "implicit")
PAIRS = tuple((kind, call) for kind in KINDS for call in kind.calls)


@dataclass(frozen=True)
class Setting:
    """Version of FMI, algorithm, if the FMUs turn their state into bytes, if steps are adaptive."""

    version: int
    algorithm: str
    serial: bool = True
    adaptive: bool = False

    @property
    def options(self) -> str:
        """Options of the C FMUs."""
        if self.version == 1:
            return ""
        return "+state+bytes" if self.serial else "+state"


@dataclass(frozen=True)
class Case:
    """A setting and the fault that strikes in it."""

    setting: Setting
    fault: Fault

    def __str__(self) -> str:
        return f"{self.setting}: {self.fault.plan.strip()}"

    def same_until(self, whole: Results) -> float:
        """Time [s] before which rows equal the undisturbed: up to the step that was discarded.

        A master that chooses its steps then makes shorter ones, which may end before the fault.
        """
        if self.fault.kind.name != "discard":
            return np.inf
        return float(np.nextafter(whole.time[whole.time <= self.fault.since][-1], np.inf))


def case(seed: int, number: int) -> Case:
    """The case of a number: all kinds in all calls come in turn, everything else is random."""
    pairs = list(PAIRS)
    random.Random(seed).shuffle(pairs)
    kind, call = pairs[number % len(pairs)]
    chance = random.Random(f"{seed} {number}")
    version = chance.choice(list(NAMES[call]))
    algorithms = [name for name in ALGORITHMS if version > 1 or name != "implicit"]
    if call in STATES:
        algorithms = algorithms[2:]
    serial = call in BYTES or chance.random() < 0.7
    adaptive = version > 1 and chance.random() < 0.2
    setting = Setting(version, chance.choice(algorithms), serial, adaptive)
    component = chance.choice(list(COMPONENTS))
    since, count = 0.0, chance.choice([1, 1, 1, 2])
    if call in (*STATES, *BYTES):
        since, count = chance.uniform(0.0, 0.5 * STOP), 1
    elif call in RUNNING and chance.random() < 0.85:
        since, count = chance.uniform(0.0, 0.95 * STOP), chance.randint(1, 5)
    return Case(setting, Fault(component, call, kind, since, count))


class Campaign:
    """FMUs and undisturbed results, made once for each setting, in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.fmus = cache(self._fmus)
        self.whole = cache(self._whole)

    def _fmus(self, version: int, options: str) -> Mapping[str, Path]:
        return {
            name: build_faulty(version, model + options, self.folder)
            for name, model in COMPONENTS.items()
        }

    def _whole(self, setting: Setting) -> Results:
        folder = self.folder / str(setting).replace(" ", "")  # gcc leaves files where it has blanks
        place = self.place(setting, folder, disturbed=False)
        done = place.run()
        assert done.code == 0, done.err
        left = place.left_behind(done)
        assert left == [], left
        return place.results()

    def place(self, setting: Setting, folder: Path, *, disturbed: bool = True) -> Place:
        """A folder with the system of a setting; checkpoints are asked for if it is disturbed."""
        place = Place(folder)
        fmus = self.fmus(setting.version, setting.options)
        more = {"coupling_tolerance": 1e-3} if setting.adaptive else {}
        if disturbed:
            more["checkpoint_interval"] = CHECKPOINTS
        write_system(place, fmus, algorithm=setting.algorithm, **more)
        return place

    def check(self, case: Case, folder: Path) -> str:
        """Make the run of a case, and resume it; returns one line about it.

        AssertionError where anything is not as it must be.
        """
        fault, whole = case.fault, self.whole(case.setting)
        place = self.place(case.setting, folder)
        if fault.kind.name == "locale":
            provide_locale(folder / "faults")
        place.arm(fault)
        done = place.run()
        struck = place.has_struck(fault)
        told = f"{case} struck: {struck}, exit code {done.code}, {done.seconds:.1f} s\n{done.err}"
        assert done.code is not None, f"no end\n{told}"
        assert place.left_behind(done) == [], told
        fails = done.code != 0 if fault.kind.outcome == "either" else fault.kind.outcome == "fails"
        if struck and fails:
            self._check_failed(case, place, done, told)
        else:
            assert done.code == 0, told
            assert differences(place.results(), whole, complete=True, but="messages") == [], told
            return told
        self.check_resumed(place, case.setting, case.same_until(whole))
        return told

    def _check_failed(self, case: Case, place: Place, done: Done, told: str) -> None:
        fault = case.fault
        assert done.code == 1, told
        for pattern in says(case):
            assert re.search(pattern, done.err), f"{pattern} is not in\n{told}"
        assert "Traceback" not in done.err, told
        if not (place.folder / "r.nc").exists():
            assert fault.since < 2 * STEP, f"no rows\n{told}"
            return
        found = place.results()
        whole = self.whole(case.setting)
        wrong = differences(found, whole, complete=False, before=case.same_until(whole))
        assert wrong == [], told
        assert found.time[-1] >= fault.since - 3 * STEP, f"rows until {found.time[-1]}\n{told}"
        if fault.call in CLOSING:
            assert differences(found, whole, complete=True) == [], told

    def check_resumed(self, place: Place, setting: Setting, before: float = np.inf) -> None:
        """Resumed without the fault, a run comes to the undisturbed results.

        Those `before` a time [s] only, if it is given.
        """
        place.arm(None)
        again = place.run(*place.resuming())
        assert again.code == 0, again.err
        assert place.left_behind(again) == []
        complete = before > STOP
        found = place.results()
        assert found.time[-1] == STOP
        wrong = differences(found, self.whole(setting), complete=complete, before=before)
        assert wrong == [], again.err


def says(case: Case) -> list[str]:
    """Patterns of the error: component, file, function, time, and the kind of fault."""
    fault, setting = case.fault, case.setting
    found = [rf"\b{fault.component}\b", fault.kind.says]
    if fault.kind.name not in ("nan", "inf", "discard"):
        found += [rf"{fault.component}\S*\.fmu|faulty_\w+\.fmu"]
        found += [] if fault.kind.name == "late" else [NAMES[fault.call][setting.version]]
    if fault.since:
        found.append(r"t = \S+ s")
    return found


def provide_locale(folder: Path) -> None:
    """A locale with a decimal comma, in a folder."""
    command = ["localedef", "-i", "de_DE", "-f", "UTF-8", str(folder / "de_DE.UTF-8")]
    subprocess.run(command, check=True)
