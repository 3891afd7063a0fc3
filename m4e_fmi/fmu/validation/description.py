"""Group `description`: what the archive and the XML say, before any FMU code is run."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import fmpy
from fmpy.model_description import ValidationError
from lxml import etree

from m4e_fmi.fmu.importer.elements import FmpyDescription
from m4e_fmi.fmu.importer.flaws import Flaw, flaws, undefined_units
from m4e_fmi.fmu.importer.opening import MODEL_DESCRIPTION
from m4e_fmi.fmu.importer.reading import fmpy_message
from m4e_fmi.fmu.validation.findings import SHOWN, Finding
from m4e_fmi.fmu.validation.subject import CLASSES, FmuUnderTest, TooLargeError
from m4e_fmi.fmu.validation.variables import check_units, check_variables
from m4e_fmi.shown import first_of

_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)
_NOT_LOADED = ("library.identifier", "library.missing")


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
    try:
        subject = FmuUnderTest(folder, raw)
    except TooLargeError as error:
        found.append(Finding("description.limits", "warning", str(error), "it is not run, either"))
        return tuple(found), str(error)
    if not subject.ways:
        return tuple(found), "it is for scheduled execution only, which is not checked"
    found += check_variables(subject)
    found += check_units(subject)
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
                remedy = f"there is {first_of(others, SHOWN)}: its name must be the modelIdentifier"
            elif any((subject.folder / "sources").glob("**/*.c")):
                remedy += "; sources are enough for the standard, but have to be compiled first"
            yield Finding("library.missing", "error", message, remedy)
