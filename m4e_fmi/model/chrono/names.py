"""Names and places: what is called how here, and where in the file it stands."""

from __future__ import annotations

import re
from collections.abc import Container
from typing import Protocol

from m4e_fmi.errors import Problem
from m4e_fmi.files.document import Document, Location
from m4e_fmi.model.elements import identifier

GROUPS = ("bodies", "joints", "tsdas", "rsdas", "motors", "body_loads")


def fresh(name: str, taken: Container[str]) -> str:
    """`name`, with a number if it is taken: each of Chrono's kinds has names of its own."""
    number, found = 1, name
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    return found


class Named(Protocol):
    """A section with a name."""

    @property
    def name(self) -> str:
        """The section's name."""
        ...


class Places:
    """Problems found, each at its entry of the document; entries are known by group and name."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.problems: list[Problem] = []
        self._entries: dict[tuple[str, str], Location] = {}
        for group in GROUPS:
            for k, entry in enumerate(entries(document.data, group)):
                if isinstance(entry, dict) and isinstance(entry.get("name"), str):
                    self._entries.setdefault((group, entry["name"]), ("model", group, k))

    def at(self, location: Location, message: str, remedy: str = "") -> None:
        """Note a problem at a place of the document."""
        self.problems.append(self.document.problem(location, message, remedy))

    def of(self, group: str, name: str) -> Location:
        """Where an element of ours with this name comes from: its entry, or the whole model."""
        for (kind, said), location in self._entries.items():
            if kind == group and identifier(said) == name:
                return location
        return ("model",)

    def say(self, entry: Named, message: str, within: Location = (), remedy: str = "") -> None:
        """Note a problem at an entry (a section with a name), or at a key within it."""
        location = self._entries.get((group_of(entry), entry.name), ("model",))
        self.at((*location, *within), message, remedy)


def group_of(entry: object) -> str:
    """The group whose sections are of this class: BodyLoadSection → body_loads."""
    words = re.findall(r"[A-Z][a-z]+", type(entry).__name__.removesuffix("Section"))
    singular = "_".join(words).lower()
    return "bodies" if singular == "body" else f"{singular}s"


def entries(data: object, group: str) -> list[object]:
    """The entries of a group in a file's plain data, whatever they are."""
    model = data.get("model") if isinstance(data, dict) else None
    found = model.get(group) if isinstance(model, dict) else None
    return found if isinstance(found, list) else []
