"""Input files with random damage, and what becomes of them: a message or a result, nothing else.

A seed is a set of files and the commands that read the first of them. `Case` damages one file and
gives it to one command, in a folder of its own.
"""

from __future__ import annotations

import io
import json
import random
import signal
import time
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from support import defects, packages, paper_listings
from support.chrono_files import chrono_model
from support.flap_file import TEXT, WAVE

from m4e_fmi.cli import main
from m4e_fmi.cosim import load_system
from m4e_fmi.errors import InputError, M4eError, RunError

ROOT = Path(__file__).parents[2]
LONGEST = 5.0
"""Seconds of processor time that a case may take."""
DEFECT = "this is a defect of m4e_fmi"
Files = Mapping[str, bytes]

WORDS = (
    "[]", "{}", "null", "~", "true", "''", "1e300", "-1e-300", "1e-300", "1e200", "-1e155", "1e999",
    ".nan", ".inf", "-1", "0", "9" * 5000, "0x7fffffffffffffffffff", "1_000", "2001-01-01",
    "2001-13-45", "!!binary x", "!!set {a, b}", "!!omap [a: 1]", "!!timestamp x", "!!int x",
    "!!float x", "!!python/name:os.system x", "*a", "&a [*a]", "&a {a: *a}", "../../x", "/abs/x",
    "con", "nul.txt", "a/b", '"a\\u202eb\\u001b[2J"', "'@sections@'", "x" * 3000, "sign(1e308*10)",
    "1/0", "0**-1", "(-1)**0.5", "log(0)", "1e308*1e308", "exp(1e9)", "2**1e5", "1e300**2", "t",
    "sin(", "__import__('os').abort()", "(" * 500, "1" + "+1" * 3000, "- a", "a: b", "? a",
    "<<: *x", "/dev/null", "/proc/self/environ", "/", ".", "\u00b2", "\ud7ff", "1e100", "1e-100",
)  # fmt: skip
BYTES = (
    b"\0",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\r",
    b"\t",
    b"\x1b[2J",
    b"\xc2\x85",
    b"%",
    b"<",
    b"&",
)
XML_WORDS = (
    "", "x", "-1", "1e400", "NaN", "INF", "4294967296", "99999999999999999999", "../../x", "/abs/x",
    "true", "1 2 3", "3000", "con", "x" * 3000, "&#x202e;&#10;", "@sections@", "2.0", "3.0", "1.0",
    "0", "Real", "input", "fixed", "0.5.5",
)  # fmt: skip


@dataclass(frozen=True)
class Seed:
    """Files, of which the first is read; each command has its path in place of FILE."""

    name: str
    files: Files
    commands: tuple[tuple[str, ...], ...]
    damaged: tuple[str, ...] = ()
    """Names of those that are damaged; the first if there are none."""


def _archive(files: Mapping[str, bytes | str]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name), content)
    return file.getvalue()


def _fmu(text: str, library: str = f"{fmpy.platform}/{defects.NAME}") -> bytes:
    """An FMU whose library is empty: it can be read, but not be loaded."""
    library = f"binaries/{library}{fmpy.sharedLibraryExtension}"
    return _archive({defects.XML: text, library: b""})


FMI_3 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="a" instantiationToken="a">
<CoSimulation modelIdentifier="a" canHandleVariableCommunicationStepSize="true"/>
<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>
<DefaultExperiment startTime="0" stopTime="1" stepSize="0.1"/>
<ModelVariables>
<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
<UInt64 name="n" valueReference="1" causality="structuralParameter" variability="fixed" start="3"/>
<Float64 name="u" valueReference="2" causality="input" start="1 2 3"><Dimension valueReference="1"/>
</Float64>
<Float64 name="y" valueReference="3" causality="output" unit="m"><Alias name="z"/></Float64>
<Boolean name="b" valueReference="4" causality="parameter" variability="fixed" start="true"/>
<String name="s" valueReference="5" causality="parameter" variability="fixed"><Start value="a"/></String>
</ModelVariables>
<ModelStructure><Output valueReference="3" dependencies="2"/>
<InitialUnknown valueReference="3"/></ModelStructure></fmiModelDescription>
"""  # noqa: E501


def _models() -> Iterator[Seed]:
    read = (("info", "FILE"), ("equations", "FILE"))
    simulate = (("simulate", "FILE", "--stop-time", "0.01", "--no-plot"),)
    for path in sorted((ROOT / "examples").rglob("*.model.yaml")):
        small = path.stat().st_size < 2500
        commands = (*read[:1], *(simulate if small else ()), *(read[1:] if small else ()))
        yield Seed(path.stem, {"a.model.yaml": path.read_bytes()}, commands)
    flap = {"flap.model.yaml": TEXT.encode(), "wave.csv": WAVE.encode()}
    yield Seed("flap", flap, (read[0], *simulate), tuple(flap))
    lists = paper_listings.spiderfloat()
    lists["Force"].pop("CG")
    text = _json(lists).replace(b"NaN", b"null")
    yield Seed("lists", {"lists.yaml": text}, read[:1])
    yield Seed("chrono", {"chrono.yaml": _json(chrono_model(lists))}, read[:1])


def _json(data: object) -> bytes:
    def plain(value: Any) -> Any:
        return value.tolist() if isinstance(value, np.ndarray) else float(value)

    return json.dumps(data, default=plain, indent=1).encode()


TABLES = """name: tables
components:
  wind: {kind: table, file: wind.csv, signals: {speed: m/s}}
  all: {kind: sum, unit: m/s, inputs: [a, b]}
connections: [wind.speed -> all.a]
simulation: {stop_time: 1, step_size: 0.1}
"""
FMUS = """name: fmus
components:
  one: {fmu: one.fmu, start: {mass: 3}}
  two: {fmu: one.fmu}
connections: [one.load -> two.force]
outputs: {x: two.x}
simulation: {stop_time: 1, step_size: 0.1, algorithm: jacobi}
"""
SET = "name: light\nvalues: {one.mass: 2, one.damping: 0.1, two.on: true, two.text: a}\n"


def _systems() -> Iterator[Seed]:
    load = (("load_system", "FILE"),)
    for path in sorted((ROOT / "examples").rglob("system.yaml")):
        if path.parent.name != "hydraulic_pto":  # whose kinds may not be installed
            models = {p.name: p.read_bytes() for p in path.parent.glob("*.model.yaml")}
            files = {path.name: path.read_bytes(), **models}
            yield Seed(f"system {path.parent.name}", files, load, (path.name,))
    files = {"system.yaml": TABLES.encode(), "wind.csv": b"time,speed\n0,1\n1,2\n"}
    yield Seed("system tables", files, (*load, ("make", "FILE")), tuple(files))
    files = {"system.yaml": FMUS.encode(), "one.fmu": _fmu(defects.description())}
    yield Seed("system fmus", files, (*load, ("info", "FILE")), tuple(files))
    yield Seed("parameters", {"set.yaml": SET.encode()}, (("parameters", "FILE"),))
    values = packages.parameter_set({"one.mass": 'Real value="2"', "one.name": 'String value="a"'})
    yield Seed("ssv", {"set.ssv": values.encode()}, (("parameters", "FILE"),))


def _ssd() -> str:
    parts = "".join(packages.component(n, "one.fmu") for n in ("one", "two"))
    return packages.description(f"<ssd:Elements>{parts}</ssd:Elements>")


def _archives() -> Iterator[Seed]:
    read = (("info", "FILE"), ("info", "--json", "FILE"), ("describe", "FILE"))
    check = (("validate", "--only", "description", "FILE"),)
    yield Seed("fmi 2", {"a.fmu": _fmu(defects.description())}, (*read, *check))
    three = _fmu(FMI_3, f"{fmpy.platform_tuple}/a")
    yield Seed("fmi 3", {"a.fmu": three}, (*read, *check))
    inside = {"SystemStructure.ssd": _ssd(), "resources/one.fmu": _fmu(defects.description())}
    yield Seed("ssp", {"a.ssp": _archive(inside)}, (("load_system", "FILE"),))


MESH = b"hull\n1 9.81\n0 0\n1\n0 0 0\n1 0 0\n1 0 -1\n0 0 -1\n"


def seeds() -> list[Seed]:
    """All seeds."""
    case1 = (ROOT / "tests" / "data" / "moordyn" / "moorpy_case1.dat").read_bytes()
    return [
        *_models(),
        *_systems(),
        *_archives(),
        Seed("mesh", {"hull.gdf": MESH}, (("mesh", "FILE"),)),
        Seed("lines", {"lines.dat": case1}, (("lines", "FILE"),)),
    ]


# ---- damage ----


def damaged(content: bytes, name: str, rng: random.Random) -> bytes:
    """The content of a file with one to three pieces of damage."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        if zipfile.is_zipfile(io.BytesIO(content)):
            content = _damaged_archive(content, rng)
        elif rng.random() < 0.15:
            content = _damaged_bytes(content, rng)
        else:
            content = _damaged_text(content, name, rng)
    return content


def _damaged_bytes(content: bytes, rng: random.Random) -> bytes:
    place = rng.randrange(len(content) + 1)
    match rng.randrange(4):
        case 0:
            return content[:place]
        case 1:
            return content[:place] + rng.choice(BYTES) + content[place:]
        case 2:
            return content[:place] + bytes([rng.randrange(256)]) + content[place + 1 :]
        case _:
            with suppress(UnicodeDecodeError):
                return content.decode().encode("utf-16")
            return content


def _damaged_text(content: bytes, name: str, rng: random.Random) -> bytes:
    text = content.decode("utf-8", "replace")
    xml = text.lstrip().startswith("<")
    pieces = _pieces(text, '"' if xml else "")
    lines = text.split("\n")
    k = rng.randrange(len(lines))
    match rng.randrange(8):
        case 0:
            del lines[k]
        case 1:
            lines.insert(k, lines[rng.randrange(len(lines))])
        case 2:
            lines[k] = " " * rng.randrange(6) + lines[k].strip()
        case _ if pieces:
            begin, end = rng.choice(pieces)
            word = rng.choice(XML_WORDS if xml or name.endswith(".csv") else WORDS)
            if rng.random() < 0.2:
                other = rng.choice(pieces)
                word = text[other[0] : other[1]]
            return (text[:begin] + word + text[end:]).encode("utf-8", "replace")
    return "\n".join(lines).encode("utf-8", "replace")


def _pieces(text: str, quote: str) -> list[tuple[int, int]]:
    """Where words begin and end: between quotes, or what a line has between its separators."""
    import re

    pattern = f"(?<=={quote})[^{quote}]*" if quote else r"[^\s\[\]{},:#\"'<>]+"
    return [m.span() for m in re.finditer(pattern, text)]


def _damaged_archive(content: bytes, rng: random.Random) -> bytes:
    if rng.random() < 0.2:
        return _damaged_bytes(content, rng)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            files = {info.filename: archive.read(info) for info in archive.infolist()}
    except Exception:  # noqa: BLE001  of damage that came before
        return content
    if not files:
        return content
    name = rng.choice(list(files))
    if rng.random() < 0.15:
        files[
            rng.choice(("../out", "/out", "a\\b", "x" * 300, "con", name.upper(), "a/../../b"))
        ] = b""
    elif name.endswith((".xml", ".ssd")):
        files[name] = damaged(files[name], name, rng)
    elif rng.random() < 0.5:
        del files[name]
    else:
        files[name] = damaged(files[name], name, rng) if files[name] else b"\x7fELF" + bytes(60)
    return _archive(files)


# ---- what becomes of it ----


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


def _load_system(path: Path) -> None:

    load_system(path)


def _make(path: Path) -> None:
    from m4e_fmi.cosim.system.component import Kind, kind_module

    system = load_system(path)
    for part in system.components:
        if isinstance(part.source, Kind):
            module = kind_module(part.source.name)
            module.make(
                part.source.config, name=part.name, folder=system.folder, progress=lambda _: None
            )


def _parameters(path: Path) -> None:
    from m4e_fmi.cosim import read_parameters

    read_parameters(path)


def _describe(path: Path) -> None:
    from m4e_fmi.fmu.importer.reading import read_description

    read_description(path)


def _mesh(path: Path) -> None:
    from m4e_adapters.hydrodynamics.geometry.mesh import _loaded

    _loaded(path, "hull")


def _lines(path: Path) -> None:
    from m4e_adapters.moordyn import ready_mooring

    ready_mooring(path, fairleads={})


READERS: dict[str, Callable[[Path], None]] = {
    "load_system": _load_system,
    "make": _make,
    "parameters": _parameters,
    "describe": _describe,
    "mesh": _mesh,
    "lines": _lines,
}
"""Actions through Python, where a command would also build and run."""


def codes(seed: Seed, folder: Path) -> list[int]:
    """Exit codes of all commands of a seed without damage."""
    for name, content in seed.files.items():
        (folder / name).write_bytes(content)
    return [_done(command, folder / next(iter(seed.files)), folder) for command in seed.commands]


def outcome(seed: Seed, rng: random.Random, folder: Path) -> str:
    """Defect in how a damaged file is dealt with; an empty text if there is none."""
    work = folder / "inside" / "work"
    work.mkdir(parents=True)
    spoilt = rng.choice(seed.damaged or tuple(seed.files)[:1])
    for name, content in seed.files.items():
        (work / name).write_bytes(damaged(content, name, rng) if name == spoilt else content)
    command = rng.choice(seed.commands)
    first = work / next(iter(seed.files))
    began = time.process_time()
    told = io.StringIO()
    try:
        with _watched(LONGEST), redirect_stdout(told), redirect_stderr(told):
            code = _done(command, first, work)
    except HangError:
        return f"{seed.name} {command}: no end after {LONGEST:g} s"
    except BaseException as error:  # noqa: BLE001  this is what is looked for
        return f"{seed.name} {command}: {type(error).__name__}: {error}"
    text = told.getvalue()
    if DEFECT in text or code not in (0, 1, 2):
        return f"{seed.name} {command}: exit code {code}: {text[-500:]}"
    if any(ord(c) < 32 and c not in "\n\t\r" for c in text) or "\u202e" in text:
        return f"{seed.name} {command}: control characters in {text[:300]!r}"
    outside = [p for p in folder.rglob("*") if p.is_file() and work not in p.parents]
    if outside:
        return f"{seed.name} {command}: written outside: {outside}"
    if time.process_time() - began > LONGEST:
        return f"{seed.name} {command}: {time.process_time() - began:.1f} s"
    return ""


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
            return main(given)
        except SystemExit as error:
            return int(str(error.code))
    try:
        reader(path)
    except InputError as error:
        print(str(error).encode("ascii", "replace"))
        return 2
    except (M4eError, RunError):
        return 1
    return 0
