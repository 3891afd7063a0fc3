"""Laws of parts whose equations hold about a point only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable


@runtime_checkable
class LocalLaw(Protocol):
    """The `origin` of a part whose equations hold about a point only, such as a tangent.

    Parameters of the part say where that is and how it is there.
    """

    @property
    def errors(self) -> Mapping[str, float]:
        """Errors of the parameters that were found last, in their units; of others 0."""
        ...

    def parameters_at(self, inputs: Mapping[str, float]) -> Mapping[str, float]:
        """The parameters with which the part holds about these values of its inputs, by name.

        RunError where that cannot be found out.
        """
        ...
