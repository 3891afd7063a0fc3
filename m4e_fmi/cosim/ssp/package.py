"""The archive of an SSP package and the XML files in it, checked before anything is used."""

from __future__ import annotations

import hashlib
import lzma
import os
import zipfile
import zlib
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote, urlsplit

from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]  it has no types

from m4e_fmi.cosim.ssp.names import SCHEMAS, SSD_FILE
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.file_names import file_stem
from m4e_fmi.files.writing import written
from m4e_fmi.fmu.importer.opening import check_entries, has_doctype

SUFFIX = ".ssp"
"""Suffix of an SSP package; any other file with a system is YAML."""
Element = Any
"""An lxml element."""
MAX_XML = 50_000_000
"""Bytes of an XML file that is read."""


class Package:
    """A folder of files inside an archive; `problems` and `notes` collect what is found in them.

    InputError at once if the archive is not readable, or should not be read.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.problems: list[Problem] = []
        self.notes: dict[str, None] = {}
        if not self.path.is_file():
            folder = self.path.parent
            near = [p.name for p in folder.glob("*.ssp")] if folder.is_dir() else []
            raise self._wrong("no such file", suggestion(self.path.name, near, "packages here"))
        try:
            with zipfile.ZipFile(self.path) as archive:
                check_entries(self.path, archive)
                self.names = set(archive.namelist())
        except (zipfile.BadZipFile, OSError) as error:
            remedy = "copy or export the file again: it is truncated, or was never an SSP package"
            raise self._wrong(f"not a readable ZIP archive: {error}", remedy) from error
        if SSD_FILE not in self.names:
            message = f"not an SSP package: there is no {SSD_FILE} at the top of the archive"
            raise self._wrong(message, "pack the content of the folder, not the folder itself")

    def _wrong(self, message: str, remedy: str) -> InputError:
        return InputError.single(message, remedy, str(self.path))

    def reject(self, element: Element, message: str, remedy: str = "") -> None:
        """Note a problem with what `element` says."""
        self.problems.append(self.problem(element, message, remedy))

    def problem(self, element: Element, message: str, remedy: str = "") -> Problem:
        """A problem with what `element` says, at its place."""
        file = element.getroottree().docinfo.URL or ""
        return Problem(message, remedy, file, element.sourceline or 0)

    def note(self, text: str) -> None:
        """Note what is left out or changed."""
        self.notes.setdefault(text)

    def bytes(self, name: str) -> bytes:
        """Content of a file in the archive."""
        try:
            with zipfile.ZipFile(self.path) as archive:
                return archive.read(name)
        except (
            zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, OSError, RuntimeError,
            ValueError,
        ) as error:  # fmt: skip
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
        content = self.bytes(name)
        if len(content) > MAX_XML:
            raise self._wrong(f"{name} has {len(content) / 1e6:.0f} MB", "expected less than 50 MB")
        return parse(content, f"{self.path}/{name}", namespace)


def parse(content: bytes, file: str, namespace: str) -> Element:
    """Root element of XML text after its schema's check; InputError with all that is wrong."""
    if has_doctype(content):
        remedy = "do not use this file unless you know why it has one"
        raise InputError.single("has a DOCTYPE, which SSP does not use", remedy, file)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True,
        remove_pis=True, huge_tree=False,
    )  # fmt: skip
    try:
        root = etree.fromstring(content, parser, base_url=file)
    except etree.XMLSyntaxError as error:
        problem = Problem(f"not well-formed XML: {error.msg}", "", file, error.lineno or 0)
        raise InputError([problem]) from None
    check(root, file, namespace)
    return root


def check(root: Element, file: str, namespace: str) -> None:
    """InputError with all that the schema of `namespace` finds wrong below `root`."""
    version = root.get("version", "")
    if version and not version.startswith("1."):
        message = f"is SSP {version}; SSP 1.0 is read here"
        raise InputError([Problem(message, "export it as SSP 1.0", file, root.sourceline or 0)])
    schema = _schema(namespace)
    if not schema.validate(root):
        raise InputError(
            Problem(f"against the SSP schema: {entry.message}", "", file, entry.line)
            for entry in schema.error_log
        )


@cache
def _schema(namespace: str) -> Any:
    import fmpy

    folder = Path(fmpy.__file__).parent / "ssp" / "schema"
    return etree.XMLSchema(file=str(folder / SCHEMAS[namespace]))


def unpack_member(package: Path, member: str, folder: Path) -> Path:
    """`member` of the archive `package` as a file in `folder`, named after itself and its content.

    So members of one name, of several packages or folders in them, never take each other's place.
    """
    content = Package(package).bytes(member)
    path = PurePosixPath(member)
    target = (
        folder / f"{file_stem(path.stem)}-{hashlib.sha256(content).hexdigest()[:12]}{path.suffix}"
    )
    if target.is_file() and target.read_bytes() == content:
        return target
    with written(target) as part:
        part.write_bytes(content)
    return target
