"""The record of a run that its results carry for reports: graph, power flows, errors, inputs.

The attribute `record` is written when the results begin, `record_end` when the run has ended.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar

from m4e_fmi.errors import InputError
from m4e_fmi.report.graph import Graph

if TYPE_CHECKING:
    from pydantic import TypeAdapter

ATTRIBUTE, END = "record", "record_end"
"""Names of the attributes."""
FORMAT = 1
LONGEST = 200_000
"""Characters of an input file that are kept; of a longer one there is only its SHA-256."""


@dataclass(frozen=True)
class Product:
    """A part of a power [W]: `factor` · variable `force` · variable `velocity`, in their units."""

    force: str
    velocity: str
    factor: float


@dataclass(frozen=True)
class Flow:
    """Power over a connection, positive from the component `source` into the component `target`.

    `adds` are components whose forces the source adds up.
    """

    connection: str
    source: str
    target: str
    products: tuple[Product, ...]
    adds: tuple[str, ...] = ()


@dataclass(frozen=True)
class InputFile:
    """A text file that a run was made of; `text` is None if it is too long to be kept."""

    name: str
    sha256: str
    text: str | None


@dataclass(frozen=True)
class Record:
    """All that is known when a run begins.

    `fmus` are files by component, with their SHA-256; `versions` those of Python, of packages and
    of the platform.
    """

    format: int = FORMAT
    graph: Graph | None = None
    flows: tuple[Flow, ...] = ()
    inputs: tuple[InputFile, ...] = ()
    fmus: dict[str, str] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class FlowEnergy:
    """Energies [J] of a flow over the whole run, by the run itself: see `BondEnergy`."""

    given: float
    received: float
    exchanged: float
    noise: float = 0.0


@dataclass(frozen=True)
class StatedError:
    """Largest estimated error of a connection, at the variable `source`, of the range `span`."""

    connection: str
    source: str
    error: float
    halved: float
    span: float
    unit: str


@dataclass(frozen=True)
class RecordEnd:
    """All that is known when a run has ended; `energies` are those of the flows, in their order."""

    format: int = FORMAT
    steps: int | None = None
    rejected: int = 0
    energies: tuple[FlowEnergy, ...] = ()
    errors: tuple[StatedError, ...] = ()


class _Formatted(Protocol):
    @property
    def format(self) -> int: ...


Kept = TypeVar("Kept", bound=_Formatted)


def carried_record(record: Record | RecordEnd) -> dict[str, str]:
    """The attribute by which results carry a record."""
    name = ATTRIBUTE if isinstance(record, Record) else END
    return {name: json.dumps(asdict(record), separators=(",", ":"))}


def record_of(attributes: Mapping[str, str], path: str) -> Record:
    """The record in attributes of the results at `path`, an empty one if there is none.

    InputError if it is damaged.
    """
    found = read_record(Record, attributes.get(ATTRIBUTE, "{}"), FORMAT, path, "run it again")
    if found.graph and not found.graph.is_whole:
        raise InputError.single("its record is damaged", "run it again", path)
    return found


def end_of(attributes: Mapping[str, str], path: str) -> RecordEnd:
    """The same of what is known when a run has ended."""
    return read_record(RecordEnd, attributes.get(END, "{}"), FORMAT, path, "run it again")


def read_record(kind: type[Kept], text: str, newest: int, path: str, remedy: str) -> Kept:
    """The record of a `kind` in the `text` (JSON) of an attribute of the results at `path`.

    InputError if it is damaged, or of a format above the `newest`.
    """
    from pydantic import TypeAdapter, ValidationError

    adapter: TypeAdapter[Kept] = TypeAdapter(kind)
    try:
        found = adapter.validate_json(text)
    except (ValidationError, RecursionError):
        message = "its record is damaged, or of another m4e_fmi"
        raise InputError.single(message, remedy, path) from None
    if found.format > newest:
        message = f"its record is of format {found.format}, newer than this m4e_fmi"
        raise InputError.single(message, "update m4e_fmi", path)
    return found


def input_file(path: Path, name: str, *, kept: bool = True) -> InputFile | None:
    """A file, with its text if that is `kept` and not too long; None if it cannot be read."""
    try:
        data = path.read_bytes() if path.is_file() else None
    except (OSError, ValueError):
        return None
    if data is None:
        return None
    text = None
    if kept and len(data) <= LONGEST:
        text = data.decode("utf-8-sig", errors="replace").replace("\r\n", "\n")
    return InputFile(name, hashlib.sha256(data).hexdigest(), text)
