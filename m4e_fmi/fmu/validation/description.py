"""Group `description`: what the archive and the XML say, before any FMU code is run.

Symbols of a library of Linux are read from its dynamic section. Source: Tool Interface Standard,
Executable and Linking Format, version 1.2, book III; version needs: Linux Standard Base Core
Specification, section 10.7.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import fmpy
from fmpy.model_description import ValidationError
from lxml import etree

from m4e_fmi.errors import InputError
from m4e_fmi.files.xml_text import check_size, xml_root
from m4e_fmi.fmu.importer.elements import FmpyDescription, array_name
from m4e_fmi.fmu.importer.flaws import Flaw, flaws, undefined_units
from m4e_fmi.fmu.importer.opening import MODEL_DESCRIPTION, TERMINALS
from m4e_fmi.fmu.importer.reading import fmpy_message
from m4e_fmi.fmu.validation.findings import Finding, about, some
from m4e_fmi.fmu.validation.subject import CLASSES, FmuUnderTest, TooLargeError
from m4e_fmi.fmu.validation.variables import check_names, check_units, check_variables

TERMINALS_BASIS = "FMI 3.0.2, section 2.4.9"
_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)
_SECTION = struct.Struct("<IIQQQQIIQQ")
_SYMBOL = struct.Struct("<IBBHQQ")
_DYNAMIC = struct.Struct("<QQ")
_NEED = struct.Struct("<HHIII")
_NEEDED_VERSION = struct.Struct("<IHHII")
_DYNSYM, _DYNAMIC_SECTION, _VERNEED = 11, 6, 0x6FFFFFFE
_NEEDED_LIBRARY = 1
_GLOBAL = (1, 2)  # bindings STB_GLOBAL, STB_WEAK
_NOT_LOADED = ("library.identifier", "library.missing", "library.exports")


def description_findings(folder: Path) -> tuple[tuple[Finding, ...], str]:
    """Findings on the FMU unpacked in `folder`; why it cannot be run, "" if it can."""
    text = (folder / MODEL_DESCRIPTION).read_bytes()
    flawed = flaws(text)
    problems, raw = _read(folder, text, flawed)
    found = [
        Finding("description.invalid", "error", told, "FMI's XML schema and FMPy's rules")
        for told in problems
    ]
    if raw is None:
        return tuple(found), "the model description cannot be understood"
    version = raw.fmiVersion
    if version not in CLASSES:
        return tuple(found), f"made for FMI 2.0 and 3.0, this is {version}"
    names = [v.name for v in raw.modelVariables]  # with aliases, and arrays as one
    try:
        subject = FmuUnderTest(folder, raw)
    except TooLargeError as error:
        found.append(Finding("description.limits", "warning", str(error), "it is not run, either"))
        return tuple(found), str(error)
    if not subject.ways:
        return tuple(found), "it is for scheduled execution only, which is not checked"
    found += check_names(names)
    found += check_variables(subject)
    found += check_units(subject)
    found += _experiment(subject)
    found += _terminals(subject)
    found += _library(subject)
    reasons = [f.message for f in found if f.id in _NOT_LOADED]
    return tuple(finding.of(version) for finding in found), next(iter(reasons), "")


def _read(folder: Path, text: bytes, flawed: list[Flaw]) -> tuple[list[str], FmpyDescription]:
    """Problems that FMPy's validator finds, and the flaws that it does not; the description
    as FMPy reads it, None if that is not possible."""
    problems: list[str] = []
    stopped, raw, new = "", None, list(flawed)
    try:
        raw = fmpy.read_model_description(
            str(folder), validate=True, validate_variable_names=True, validate_model_structure=True
        )
    except ValidationError as error:
        problems = [p for p in error.problems if not _of_aliases(p, text)]
    except Exception as error:  # noqa: BLE001  FMPy raises whatever it stumbles over
        stopped = fmpy_message(error)
        new = new or undefined_units(text)
    new = [flaw for flaw in new if not (flaw.known and problems)]
    problems += [f"{flaw.message} (line {flaw.line})" for flaw in new]
    if raw is None and not flawed:
        with suppress(Exception):  # whatever FMPy stumbles over, which has been told
            raw = fmpy.read_model_description(str(folder), validate=False)
    return problems or [stopped] * bool(stopped), None if flawed else raw


def _of_aliases(problem: str, text: bytes) -> bool:
    """True if FMPy misses nothing but aliases of FMI 3.0, which ModelStructure does not list."""
    sets = re.search(r"Expected \{(.*?)\} but was \{(.*?)\}", problem)
    if sets is None:
        return False
    expected, listed = (set(names.split(", ")) for names in sets.groups())
    aliases = etree.fromstring(text).xpath("ModelVariables/*/Alias/@name")
    return expected - listed <= set(aliases) and listed <= expected


def _experiment(subject: FmuUnderTest) -> Iterator[Finding]:
    experiment = subject.raw.defaultExperiment
    if experiment is None:
        return
    start = float(experiment.startTime or 0.0)
    stop = float(experiment.stopTime) if experiment.stopTime else None
    size = float(experiment.stepSize) if experiment.stepSize else None
    basis = "FMI 2.0.4, section 2.2.5"
    if stop is not None and not stop > start:
        message = f"the default experiment ends at {stop:g} s, not after its start at {start:g} s"
        yield Finding("experiment.times", "warning", message, basis)
    elif size is not None and not 0 < size <= (stop - start if stop is not None else size):
        message = f"the default experiment's step of {size:g} s does not fit its times"
        yield Finding("experiment.step", "warning", message, basis)
    if experiment.tolerance and not 0 < float(experiment.tolerance) < 1:
        message = f"the default experiment's relative tolerance is {experiment.tolerance}"
        yield Finding("experiment.tolerance", "warning", message, basis)
    for kind in subject.kinds:
        if kind.canSerializeFMUstate and not kind.canGetAndSetFMUstate:
            message = "canSerializeFMUstate needs canGetAndSetFMUstate, which is not declared"
            yield Finding("capabilities.serialise", "error", message, "FMI 2.0.4, section 2.1.8")


def _terminals(subject: FmuUnderTest) -> Iterator[Finding]:
    """Terminals and icons of FMI 3.0: their file can be read, and their variables are there."""
    path = subject.folder / TERMINALS
    if not (subject.fmi_3 and path.is_file()):
        return
    try:
        check_size(path.stat().st_size, TERMINALS)
        root = xml_root(path.read_bytes(), TERMINALS)
    except InputError as error:
        message = f"{TERMINALS} {error.problems[0].message}"
        yield Finding("terminals.invalid", "error", message, TERMINALS_BASIS)
        return
    names = {v.name for v in subject.raw.modelVariables} | set(
        map(array_name, subject.raw.modelVariables)
    )
    absent = [
        f"{member.get('variableName')} (line {member.sourceline})"
        for member in root.iterfind(".//TerminalMemberVariable")
        if member.get("variableName") not in names
    ]
    message = f"{TERMINALS} names variables that are not there"
    yield from about(absent, "terminals.variables", "error", message, TERMINALS_BASIS)


def _library(subject: FmuUnderTest) -> Iterator[Finding]:
    binaries = subject.folder / "binaries"
    platform = fmpy.platform if subject.raw.fmiVersion == "2.0" else fmpy.platform_tuple
    here = binaries / platform
    for identifier in sorted({str(kind.modelIdentifier) for kind in subject.kinds}):
        library = here / f"{identifier}{fmpy.sharedLibraryExtension}"
        if not _IDENTIFIER.fullmatch(identifier):  # nor is anything loaded from elsewhere
            message = f"the modelIdentifier {identifier!r} is no C identifier"
            yield Finding("library.identifier", "error", message, "FMI 2.0.4, section 2.2.1")
        elif not library.is_file():
            there = sorted(p.name for p in binaries.iterdir()) if binaries.is_dir() else []
            others = sorted(p.name for p in here.iterdir()) if here.is_dir() else []
            message = f"cannot run here: there is no binaries/{platform}/{library.name}"
            remedy = f"platforms in it: {', '.join(there) or 'none'}"
            if others:
                remedy = f"there is {some(others)}: its name must be the modelIdentifier"
            elif any((subject.folder / "sources").glob("**/*.c")):
                remedy += "; sources are enough for the standard, but have to be compiled first"
            yield Finding("library.missing", "error", message, remedy)
        elif (elf := _read_elf(library)) is not None:
            yield from _elf(subject, *elf)


def _elf(
    subject: FmuUnderTest, exports: set[str], needs: list[str], versions: set[str]
) -> Iterator[Finding]:
    version = subject.raw.fmiVersion
    classes, prefix = CLASSES[version], f"fmi{version[0]}"
    names = {name for exchange in subject.ways for name in dir(classes[exchange])}
    needed = sorted(name for name in names if name.startswith(prefix))
    missing = [name for name in needed if name not in exports]
    if missing:
        message = f"the library does not export {some(missing)}"
        basis = "all functions must be there, supported or not: FMI 2.0.4, section 2.3"
        yield Finding("library.exports", "error", message, basis)
    foreign = sorted(name for name in exports if not name.startswith("fmi"))
    message = "the library exports {count} symbols besides FMI's"
    remedy = "two libraries may clash over them in one process: hide them (visibility, -s)"
    yield from about(foreign, "library.symbols", "note", message, remedy)
    libc = [v for v in sorted(versions) if re.fullmatch(r"GLIBC_[\d.]+", v)]
    newest = max(libc, key=lambda v: [int(n) for n in v[6:].split(".")], default="no C library")
    message = f"needs {newest}; libraries: {', '.join(needs) or 'none'}"
    yield Finding("library.needs", "note", message)


SharedLibrary = tuple[set[str], list[str], set[str]]
"""Symbols that others can link to, libraries that are needed, versions such as GLIBC_2.34."""


def _read_elf(path: Path) -> SharedLibrary | None:
    """The 64-bit little-endian ELF library at `path`; None if it is something else, or damaged."""
    content = path.read_bytes()
    if content[:6] != b"\x7fELF\x02\x01":
        return None
    try:
        return _symbols(content)
    except (struct.error, IndexError, ValueError):
        return None


def _symbols(content: bytes) -> SharedLibrary:
    (offset,) = struct.unpack_from("<Q", content, 40)
    size, count = struct.unpack_from("<HH", content, 58)
    sections = [_SECTION.unpack_from(content, offset + k * size) for k in range(count)]

    def text(table: int, place: int) -> str:
        begin = sections[table][4] + place
        return content[begin : content.index(b"\0", begin)].decode("ascii", "replace")

    exports: set[str] = set()
    needs: list[str] = []
    versions: set[str] = set()
    for _, kind, _, _, begin, length, link, info, _, _ in sections:
        if kind == _DYNSYM:
            for place in range(begin, begin + length, _SYMBOL.size):
                name, how, _, section, _, _ = _SYMBOL.unpack_from(content, place)
                if section and how >> 4 in _GLOBAL:
                    exports.add(text(link, name))
        elif kind == _DYNAMIC_SECTION:
            for place in range(begin, begin + length, _DYNAMIC.size):
                tag, value = _DYNAMIC.unpack_from(content, place)
                if tag == _NEEDED_LIBRARY:
                    needs.append(text(link, value))
        elif kind == _VERNEED:
            place = begin
            for _ in range(info):
                _, entries, _, first, following = _NEED.unpack_from(content, place)
                entry = place + first
                for _ in range(entries):
                    _, _, _, name, after = _NEEDED_VERSION.unpack_from(content, entry)
                    versions.add(text(link, name))
                    entry += after
                place += following
    return exports, needs, versions
