"""Names and places: what is called how here, and where in the file it stands."""

from __future__ import annotations

from collections.abc import Container

from m4e_fmi.errors import Problem, suggestion
from m4e_fmi.files.document import Document, Location
from m4e_fmi.model.chrono.sections import ModelSection
from m4e_fmi.model.elements import GROUND, identifier

GROUPS = ("bodies", "joints", "tsdas", "rsdas", "motors", "body_loads")


def fresh(name: str, taken: Container[str]) -> str:
    """`name`, with a number if it is taken: each of Chrono's kinds has names of its own."""
    number, found = 1, name
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    return found


class Places:
    """Problems found, each at its section's place in the document."""

    def __init__(self, document: Document, model: ModelSection) -> None:
        self.document, self.model = document, model
        self.problems: list[Problem] = []
        self._of = {
            id(entry): ("model", group, k)
            for group in GROUPS
            for k, entry in enumerate(getattr(model, group))
        }

    def of(self, group: str, name: str) -> Location:
        """Where an element of ours with this name comes from: its entry, or the whole model."""
        for entry in getattr(self.model, group, ()):
            if identifier(entry.name) == name:
                return self._of[id(entry)]
        return ("model",)

    def say(self, entry: object, message: str, within: Location = (), remedy: str = "") -> None:
        """Note a problem at an entry, or at a key within it."""
        location = (*self._of[id(entry)], *within)
        self.problems.append(self.document.problem(location, message, remedy))

    def check_names(self) -> None:
        """Note names that are given twice, and bodies that are not there."""
        bodies = {body.name for body in self.model.bodies}
        for group in GROUPS:
            taken: set[str] = set()
            for entry in getattr(self.model, group):
                if (name := identifier(entry.name)) in taken:
                    message = f"{entry.name!r} would be the second {name!r}"
                    self.say(entry, message, ("name",), "rename one of the two")
                taken.add(name)
                for key in ("body", "body1", "body2"):
                    name = getattr(entry, key, None)
                    if name is not None and name not in bodies:
                        remedy = suggestion(name, bodies, "bodies")
                        self.say(entry, f"unknown body {name!r}", (key,), remedy)
        for body in self.model.bodies:
            if body.name == GROUND and not body.fixed:
                message = "'ground' is the name of the world"
                self.say(body, message, ("name",), "rename it, or 'fixed: true'")
