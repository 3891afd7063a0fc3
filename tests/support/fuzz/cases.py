"""One damaged file given to one command, and what is wrong with the outcome.

Right is exit code 0, 1 or 2 within LONGEST seconds of processor time, without a traceback, a
control character or a file elsewhere than beside the input.
"""

from __future__ import annotations

import io
import random
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from unittest import mock

from support.fuzz.archives import damaged_archive
from support.fuzz.binaries import damaged_fields, damaged_program
from support.fuzz.families import Family, Seed, is_archive
from support.fuzz.texts import WORDS, XML_WORDS, damaged_bytes, damaged_text
from support.fuzz.trees import damaged_xml, damaged_yaml

from m4e_fmi.cli import main
from m4e_fmi.cosim import load_system
from m4e_fmi.errors import InputError, M4eError
from m4e_fmi.runtime.engine import Control
from m4e_fmi.simulate import solvers

LONGEST = 5.0
"""Seconds of processor time that a case may take."""
_STEPS = 100_000
"""Steps of a simulation; its own limit takes longer than LONGEST where stiffness is huge."""
DEFECT = "this is a defect of m4e_fmi"
BINARIES = (".stl", ".nc")
TREES = (".yaml", ".xml", ".ssd", ".ssv", ".ssm")


@dataclass(frozen=True)
class Outcome:
    """`wrong` says what is wrong, "" for nothing; `past`: the file got past its first check."""

    wrong: str
    past: bool


def damaged(content: bytes, name: str, rng: random.Random) -> bytes:
    """The content of a file called `name` with one to three pieces of damage."""
    if name.endswith(TREES) and rng.random() < 0.6:
        return (damaged_yaml if name.endswith(".yaml") else damaged_xml)(content, rng)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        if name.endswith(".m4e"):
            content = damaged_program(content, rng)
        elif is_archive(content):
            content = damaged_archive(content, rng, lambda inner, n: damaged(inner, n, rng))
        elif name.endswith(BINARIES) and b"solid" not in content[:5]:
            content = (
                damaged_fields(content, rng) if rng.random() < 0.85 else damaged_bytes(content, rng)
            )
        elif rng.random() < 0.15:
            content = damaged_bytes(content, rng)
        else:
            xml = content.lstrip().startswith(b"<") or name.endswith(".csv")
            content = damaged_text(content, XML_WORDS if xml else WORDS, rng)
    return content


def codes(seed: Seed, folder: Path) -> list[int]:
    """Exit codes of all commands of a seed without damage."""
    for name, content in seed.files.items():
        (folder / name).write_bytes(content)
    return [_done(command, folder / next(iter(seed.files)), folder) for command in seed.commands]


def run_case(family: Family, number: int, start: int, folder: Path) -> Outcome:
    """Outcome of case `number` of a family, with random numbers that begin at `start`.

    The files are left in `folder`/inside/work.
    """
    seed = family.seeds[number % len(family.seeds)]
    rng = random.Random(f"{seed.name} {start} {number}")
    work = folder / "inside" / "work"
    work.mkdir(parents=True)
    spoilt = rng.choice(seed.damaged or tuple(seed.files)[:1])
    for name, content in seed.files.items():
        (work / name).write_bytes(damaged(content, name, rng) if name == spoilt else content)
    command = rng.choice(seed.commands)
    first = work / next(iter(seed.files))
    past = family.passes(first)
    wrong = _wrong(command, first, work, folder)
    return Outcome(f"{seed.name} {' '.join(command)}: {wrong}" if wrong else "", past)


def _wrong(command: tuple[str, ...], first: Path, work: Path, folder: Path) -> str:
    began = time.process_time()
    told = io.StringIO()
    try:
        with _watched(LONGEST), redirect_stdout(told), redirect_stderr(told):
            code = _done(command, first, work)
    except HangError:
        return f"no end after {LONGEST:g} s"
    except BaseException as error:  # noqa: BLE001  this is what is looked for
        return f"{type(error).__name__}: {error}"
    text = told.getvalue()
    if DEFECT in text or code not in (0, 1, 2):
        return f"exit code {code}: {text[-500:]}"
    if "not enough memory" in text:
        return "not enough memory"
    if any(ord(c) < 32 and c not in "\n\t\r" for c in text) or "\u202e" in text:
        return f"control characters in {text[:300]!r}"
    outside = [p for p in folder.rglob("*") if p.is_file() and work not in p.parents]
    if outside:
        return f"written outside: {outside}"
    taken = time.process_time() - began
    return f"{taken:.1f} s" if taken > LONGEST else ""


class HangError(BaseException):
    """The case took more than LONGEST of processor time."""


@contextmanager
def _watched(seconds: float) -> Iterator[None]:
    """Raise HangError in code of Python that takes longer, where the system has such a timer."""

    def ring(*_: object) -> None:
        raise HangError

    if not hasattr(signal, "setitimer"):
        yield
        return
    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


# ---- commands, and readers in Python where a command would also build and run ----


def _done(command: tuple[str, ...], path: Path, work: Path) -> int:
    """Exit code of a command, or of a reader as a command would give it."""
    reader = READERS.get(command[0])
    if reader is None:
        given = [str(path) if word == "FILE" else word for word in command]
        if command[0] == "simulate":
            given += ["--output-file", str(work / "out.nc")]
        if command[0] == "info":
            given += ["--build-folder", str(work / "build")]
        try:
            with mock.patch.object(solvers, "Control", partial(Control, max_steps=_STEPS)):
                return main(given)
        except SystemExit as error:
            return int(str(error.code))
    try:
        reader(path)
    except InputError as error:
        print(str(error).encode("ascii", "replace"))
        return 2
    except M4eError:
        return 1
    return 0


def _load_system(path: Path) -> None:
    load_system(path)


def _make(path: Path) -> None:
    from m4e_fmi.cosim.system.component import Kind, kind_of

    system = load_system(path)
    for part in system.components:
        if isinstance(part.source, Kind):
            kind_of(part.source.name).build(
                part.source.config, name=part.name, folder=system.folder, progress=lambda _: None
            )


def _parameters(path: Path) -> None:
    from m4e_fmi.cosim import read_parameters

    read_parameters(path)


def _describe(path: Path) -> None:
    from m4e_fmi.fmu.importer.reading import read_description

    read_description(path)


def _mesh(path: Path) -> None:
    from m4e_adapters.hydrodynamics.config.shapes import Part
    from m4e_adapters.hydrodynamics.geometry.mesh_files import drawn_panels

    drawn_panels("hull", Part(mesh=path.name), (), path.parent)


def _lines(path: Path) -> None:
    from m4e_adapters.moordyn import ready_mooring

    ready_mooring(path, fairleads={})


def _results(path: Path) -> None:
    from m4e_fmi.results.results_file import load

    repr(load(path))


def _program(path: Path) -> None:
    from m4e_fmi.program.binary_form import decode

    decode(path.read_bytes())


READERS: dict[str, Callable[[Path], None]] = {
    "load_system": _load_system,
    "make": _make,
    "parameters": _parameters,
    "describe": _describe,
    "mesh": _mesh,
    "lines": _lines,
    "results": _results,
    "program": _program,
}
