"""Origins of start values and settings that are not from a system's file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from m4e_fmi.cosim.system.component import StartValue
from m4e_fmi.errors import Problem
from m4e_fmi.files.document import Document


@dataclass(frozen=True)
class Origin:
    """A file of parameters (with its `document` if it is YAML), or "command line", or "Python".

    `value` is the given value of a setting, which a run may refine.
    """

    name: str = "Python"
    document: Document | None = None
    value: object = None

    def problem(self, variable: str, message: str, remedy: str) -> Problem:
        """A problem with the value that was given for `variable`."""
        if self.document is not None:
            return self.document.problem(("values", variable), message, remedy)
        return Problem(message, remedy, "" if self == Origin() else self.name)


class ParameterSet(dict[str, StartValue]):
    """Start values ``component.variable`` with the file they are from, as `origin`."""

    def __init__(
        self, values: Mapping[str, StartValue], path: Path, document: Document | None
    ) -> None:
        super().__init__(values)
        self.origin = Origin(str(path), document)
