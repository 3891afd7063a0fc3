"""The archive of an SSP package and the XML files in it, checked before anything is used.

The names that these files consist of: namespaces, files, types of annotations.
"""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote, urlsplit

from lxml import etree

from m4e_fmi.errors import InputError, Problem, is_file, is_other, suggestion
from m4e_fmi.files.archives import ERRORS, opened_archive
from m4e_fmi.files.file_names import file_stem
from m4e_fmi.files.files_read import file_hash
from m4e_fmi.files.limits import MB
from m4e_fmi.files.writing import written
from m4e_fmi.files.xml_text import Element, broken_names, check_size, xml_root
from m4e_fmi.units import BASE_UNITS, Unit, parse_unit

SSD_FILE = "SystemStructure.ssd"
PARAMETER_FILE = "resources/{}.ssv"
VERSION = "1.0"
_ROOT = "http://ssp-standard.org/SSP1/SystemStructure"
SSC = f"{{{_ROOT}Common}}"
SSD = f"{{{_ROOT}Description}}"
SSV = f"{{{_ROOT}ParameterValues}}"
SSM = f"{{{_ROOT}ParameterMapping}}"
SCHEMAS = {
    SSD: "SystemStructureDescription.xsd",
    SSV: "SystemStructureParameterValues.xsd",
    SSM: "SystemStructureParameterMapping.xsd",
}
"""Schema of each kind of file, among those that FMPy carries."""

FMU_TYPES = ("application/x-fmu-sharedlibrary", "application/x-fmu")
PARAMETER_SET_TYPE = "application/x-ssp-parameter-set"
PARAMETER_MAPPING_TYPE = "application/x-ssp-parameter-mapping"

OWN = "m4e_fmi"
"""Type of our annotations, whose content is JSON."""
OSP = "com.opensimulationplatform"
"""Type of the annotations of the Open Simulation Platform, which name a step."""
OSP_SPACE = "{http://opensimulationplatform.com/SSP/OSPAnnotations}"


class Package:
    """A folder of files inside an archive; `problems` and `notes` collect the findings in them.

    InputError at once if the archive is not readable, or not safe to read.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.problems: list[Problem] = []
        self.notes: dict[str, None] = {}
        if is_other(self.path):
            raise self._wrong("is a pipe or a device, not a package", "copy it into a file")
        if not is_file(self.path):
            folder = self.path.parent
            near = [p.name for p in folder.glob("*.ssp")] if folder.is_dir() else []
            raise self._wrong("no such file", suggestion(self.path.name, near, "packages here"))
        with opened_archive(self.path, "an SSP package", whole=False) as archive:
            self.names = set(archive.namelist())
        if SSD_FILE not in self.names:
            message = f"not an SSP package: there is no {SSD_FILE} at the top of the archive"
            raise self._wrong(message, "pack the content of the folder, not the folder itself")

    def _wrong(self, message: str, remedy: str) -> InputError:
        return InputError.single(message, remedy, str(self.path))

    def reject(self, element: Element, message: str, remedy: str = "") -> None:
        """Note a problem with what `element` says, at its place."""
        file = element.getroottree().docinfo.URL or ""
        self.problems.append(Problem(message, remedy, file, element.sourceline or 0))

    def note(self, text: str) -> None:
        """Note a part that is left out or changed."""
        self.notes.setdefault(text)

    def pieces(self, name: str) -> Iterator[bytes]:
        """Content of a file in the archive, piece by piece."""
        try:
            with zipfile.ZipFile(self.path) as archive, archive.open(name) as member:
                while piece := member.read(MB):
                    yield piece
        except ERRORS as error:
            raise self._wrong(f"{name} cannot be unpacked: {error}", "copy it again") from error

    def member(self, element: Element, source: str) -> str | None:
        """The file in the archive that the URI `source` names; None, with a problem, if none."""
        parts = urlsplit(source)
        name = os.path.normpath(unquote(parts.path)).replace(os.sep, "/")
        if parts.scheme or parts.netloc or parts.fragment:
            remedy = "put the file into the package's folder resources"
            self.reject(element, f"{source!r} is not a file in this package", remedy)
        elif name not in self.names:
            remedy = suggestion(name, self.names, "files in it")
            self.reject(element, f"the package holds no file {name!r}", remedy)
        else:
            return name
        return None

    def xml(self, name: str, namespace: str) -> Element:
        """Root element of an XML file of the kind that `namespace` names; InputError if wrong."""
        file = f"{self.path}/{name}"
        with zipfile.ZipFile(self.path) as archive:
            check_size(archive.getinfo(name).file_size, file)
        return parse(b"".join(self.pieces(name)), file, namespace)


def parse(content: bytes, file: str, namespace: str) -> Element:
    """Root element of XML text after its schema's check; InputError with all that is wrong."""
    return checked(xml_root(content, file), file, namespace)


def checked(root: Element, file: str, namespace: str) -> Element:
    """`root`; InputError with all that the schema of `namespace` finds wrong below it."""
    version = root.get("version", "")
    if version and not version.startswith("1."):
        message = f"is SSP {version}; SSP 1.0 is read here"
        raise InputError([Problem(message, "export it as SSP 1.0", file, root.sourceline or 0)])
    broken = broken_names(root)
    InputError.raise_for(Problem(message, "", file, line) for line, message in broken)
    schema = _schema(namespace)
    if not schema.validate(root):
        raise InputError(
            Problem(f"against the SSP schema: {entry.message}", "", file, entry.line)
            for entry in schema.error_log
        )
    return root


@cache
def _schema(namespace: str) -> Any:
    folder = files("fmpy") / "ssp" / "schema"
    return etree.XMLSchema(file=str(folder / SCHEMAS[namespace]))


def unpack_member(package: Path, member: str, folder: Path) -> Path:
    """`member` of the archive `package` as a file in `folder`, named after itself and its content.

    So members of one name, of several packages or folders in them, never take each other's place.
    """
    archive, path, digest = Package(package), PurePosixPath(member), hashlib.sha256()
    for piece in archive.pieces(member):
        digest.update(piece)
    content = digest.hexdigest()
    target = folder / f"{file_stem(path.stem)}-{content[:12]}{path.suffix}"
    if target.is_file() and file_hash(target) == content:
        return target
    with written(target) as part, part.open("wb") as file:
        for piece in archive.pieces(member):
            file.write(piece)
    return target


@dataclass(frozen=True)
class Definition:
    """A unit and what it adds after the factor (temperatures)."""

    unit: Unit
    offset: float = 0.0


def read_units(root: Element) -> dict[str, Definition]:
    """Units that a file defines, by name."""
    found = {}
    for element in root.iter(f"{SSC}Unit"):
        base = element.find(f"{SSC}BaseUnit")
        exponents = tuple(int(base.get(name, 0)) for name in BASE_UNITS)
        unit = Unit(element.get("name"), exponents, float(base.get("factor", 1)))
        found[unit.text] = Definition(unit, float(base.get("offset", 0)))
    return found


def unit_named(name: str, *known: Mapping[str, Definition]) -> Definition:
    """The first definition of `name`, or what it says itself; ValueError if it says nothing."""
    for definitions in known:
        if name in definitions:
            return definitions[name]
    return Definition(parse_unit(name))


def write_units(parent: Element, definitions: Mapping[str, Definition]) -> None:
    """Append the element `Units` to `parent`, in its own namespace, if there are any."""
    if not definitions:
        return
    units = etree.SubElement(parent, f"{{{etree.QName(parent).namespace}}}Units")
    for name, definition in sorted(definitions.items()):
        element = etree.SubElement(units, f"{SSC}Unit", name=name)
        base = etree.SubElement(element, f"{SSC}BaseUnit")
        for symbol, exponent in zip(BASE_UNITS, definition.unit.exponents, strict=True):
            if exponent:
                base.set(symbol, str(exponent))
        if definition.unit.factor != 1.0:
            base.set("factor", repr(definition.unit.factor))
        if definition.offset:
            base.set("offset", repr(definition.offset))
