"""Many cases of a family, in a process that may crash: resumable, failing inputs are kept.

`python -m support.fuzz.campaign FAMILY FIRST LAST START FOLDER` is that process: it writes the
number of each case to a file before it begins it, so that whoever started it knows which one ended
it.
"""

from __future__ import annotations

import faulthandler
import json
import os
import shutil
import subprocess
import sys
from dataclasses import asdict, dataclass, field
from pathlib import Path

from support.fuzz.cases import LONGEST, run_case
from support.fuzz.families import families

TESTS = Path(__file__).parents[2]
MEMORY = 6 * 2**30
"""Bytes of address space that a process may have."""
_SAVED_EVERY, _TOO_LONG = 25, 24
"""Cases after which the tally is saved; the signal of a process that took too long (SIGXCPU)."""


@dataclass
class Tally:
    """How far a campaign of a family is: next case, those past the first check, what was wrong."""

    next: int = 0
    past: int = 0
    wrong: list[str] = field(default_factory=list)

    def save(self, path: Path) -> None:
        """Write it, whole or not at all."""
        part = path.with_suffix(".part")
        part.write_text(json.dumps(asdict(self)), "utf-8")
        part.replace(path)

    @classmethod
    def load(cls, path: Path) -> Tally:
        """What was saved at `path`; an empty one if nothing was."""
        return cls(**json.loads(path.read_text("utf-8"))) if path.exists() else cls()


def campaign(name: str, cases: int, start: int, folder: Path) -> Tally:
    """The tally of so many cases of a family; goes on where one in `folder` was broken off."""
    folder = folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    file, case = folder / f"{name}-{start}.json", folder / f"{name}-{start}.case"
    again = -1
    while (tally := Tally.load(file)).next < cases:
        case.unlink(missing_ok=True)
        words = [name, str(tally.next), str(cases), str(start), str(folder)]
        environment = {**os.environ, "PYTHONFAULTHANDLER": "1", "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-m", "support.fuzz.campaign", *words]
        ended = subprocess.run(
            command, cwd=TESTS, env=environment, capture_output=True, text=True, errors="replace"
        )
        if ended.returncode:
            if not case.exists():
                raise RuntimeError(ended.stderr)
            number = int(case.read_text())
            tally = Tally.load(file)
            if ended.returncode == -_TOO_LONG and number != again:  # a busy machine may do that
                again = tally.next = number
                tally.save(file)
                continue
            how = f"process ended with {ended.returncode}: {ended.stderr[-2000:]}"
            tally.wrong.append(f"case {number}: {how}")
            _keep(case.with_suffix(".now"), number)
            tally.next = number + 1
            tally.save(file)
    file.unlink()
    return tally


def _work(name: str, first: int, last: int, start: int, folder: Path) -> None:
    family = families()[name]
    faulthandler.enable()
    file, case = folder / f"{name}-{start}.json", folder / f"{name}-{start}.case"
    place = case.with_suffix(".now")
    tally = Tally.load(file)
    _limit_memory()
    for number in range(first, last):
        case.write_text(str(number))
        _limit_time()
        shutil.rmtree(place, ignore_errors=True)
        outcome = run_case(family, number, start, place)
        if outcome.wrong:
            _keep(place, number)
            tally.wrong.append(f"case {number}: {outcome.wrong}")
        tally.past += outcome.past
        tally.next = number + 1
        if outcome.wrong or tally.next % _SAVED_EVERY == 0:
            tally.save(file)
    tally.save(file)
    shutil.rmtree(place, ignore_errors=True)


def _keep(place: Path, number: int) -> None:
    """Keep the input of a case in the folder `failed`."""
    kept = place.parent / "failed" / f"{place.stem}-{number}"
    shutil.rmtree(kept, ignore_errors=True)
    shutil.copytree(place / "inside" / "work", kept, dirs_exist_ok=True)


def _limit_memory() -> None:
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def _limit_time() -> None:
    """End the process, in C code too, some seconds after the case should have ended."""
    if sys.platform != "win32":
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        limit = int(used.ru_utime + used.ru_stime + 3 * LONGEST) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (limit, resource.RLIM_INFINITY))


if __name__ == "__main__":
    _, of, begin, end, first_seed, at = sys.argv
    _work(of, int(begin), int(end), int(first_seed), Path(at))
