"""Actions of a scenario as given by the user: what happens to signals and parameters, and when."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated

from pydantic import BeforeValidator, ConfigDict, model_validator

from m4e_fmi.cosim.system.simulation import Time
from m4e_fmi.files.document import Section, rejected
from m4e_fmi.files.limits import LONGEST_RUN

Amount = float | str
"""A number in the unit of its signal, or a text with a unit of its own: ``"2 cm"``."""


def _several(written: object) -> object:
    return (written,) if isinstance(written, str) else written


Names = Annotated[tuple[str, ...], BeforeValidator(_several)]
"""One name, or a list of names."""

KINDS = ("set", "ramp", "freeze", "offset", "replace", "broken_line")
"""The kinds of actions."""


def _key(field: str) -> str:
    """The key of a field in files, where it is a word of Python."""
    return "for" if field == "duration" else field


class Action(Section):
    """One action of a scenario: when it begins and ends, and what it does.

    It begins `at` a time [s], or `when` a condition as ``buoy.z > 2 m`` is first true; it ends
    after a time `for` [s] (in Python `duration`), or not at all.
    set: values by unconnected input or tunable parameter; ramp: values that these reach in equal
    steps `within` a time [s].
    freeze: signals that stay as they are. offset: amounts that are added, by signal. replace:
    values by signal. broken_line: lines of moorings that part.
    """

    model_config = ConfigDict(populate_by_name=True, alias_generator=_key)

    at: Time | None = None
    when: str | None = None
    duration: Time | None = None
    set: Mapping[str, bool | int | float | str] | None = None
    ramp: Mapping[str, Amount] | None = None
    within: Time | None = None
    freeze: Names | None = None
    offset: Mapping[str, Amount] | None = None
    replace: Mapping[str, Amount] | None = None
    broken_line: Names | None = None

    @property
    def kind(self) -> str:
        """The key that says what it does."""
        return next(kind for kind in KINDS if getattr(self, kind) is not None)

    @property
    def given(self) -> dict[str, object]:
        """Its values by the keys of files, without those that are as if they were left out."""
        fields = ((key, field.default) for key, field in type(self).model_fields.items())
        return {_key(k): getattr(self, k) for k, default in fields if getattr(self, k) != default}

    @model_validator(mode="after")
    def _whole(self) -> Action:
        for message, remedy in self._faults():
            raise rejected(message, remedy)
        return self

    def _faults(self) -> Iterator[tuple[str, str]]:
        """All that does not fit together: message and remedy."""
        kinds = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(kinds) != 1:
            what = f"does {' and '.join(kinds)}" if kinds else "does nothing"
            yield (
                f"an action {what}",
                f"give one of {', '.join(KINDS)}; several are several actions",
            )
            return
        if (self.at is None) == (self.when is None):
            told = "both 'at' and 'when'" if self.at is not None else "neither 'at' nor 'when'"
            remedy = "give a time, 'at: 10 s', or a condition, 'when: buoy.z > 2 m'"
            yield f"an action has {told}", remedy
        if self.at is not None and not abs(self.at) < LONGEST_RUN:
            yield f"'at' is {self.at:g} s", "give a time within the run"
        if "within" in self.model_fields_set and kinds[0] != "ramp":
            yield f"{kinds[0]!r} has no 'within'", "leave 'within' out"
        for key in ("duration", "within"):
            time = getattr(self, key)
            if time is not None and not 0.0 < time < LONGEST_RUN:
                name = "for" if key == "duration" else key
                yield f"{name!r} is {time:g} s", "give a time above 0"
        if kinds[0] == "ramp" and self.within is None:
            yield "a ramp without a time", "give the time that it takes, 'within: 2 s'"
        if self.within and self.duration and self.within > self.duration:
            yield (
                f"'for' ends the ramp after {self.duration:g} s, 'within' is {self.within:g} s",
                "give more 'for', or less 'within': values return when 'for' is over",
            )
        if not getattr(self, kinds[0]):
            yield f"{kinds[0]!r} names nothing", "give the name of a variable, component.variable"
