"""Actions of a scenario as given by the user: what happens to signals and parameters, and when."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from m4e_fmi.cosim.system.simulation import Time
from m4e_fmi.files.document import Section, rejected
from m4e_fmi.files.limits import LONGEST_RUN

Amount = float | str
"""A number in the unit of its signal, or a text with a unit of its own: ``"2 cm"``."""


def _several(written: object) -> object:
    return (written,) if isinstance(written, str) else written


Names = Annotated[tuple[str, ...], BeforeValidator(_several)]
"""One name, or a list of names."""

KINDS = {
    "set": (),
    "ramp": ("within",),
    "parameters": (),
    "freeze": (),
    "offset": (),
    "replace": (),
    "noise": ("seed", "every"),
    "delay": (),
    "dropout": ("gives", "share", "seed", "every"),
    "broken_line": (),
}
"""The kinds of actions, and the keys that belong to each alone."""
_OPTIONS = tuple(dict.fromkeys(key for keys in KINDS.values() for key in keys))


def _key(field: str) -> str:
    """The key of a field in files, where it is a word of Python."""
    return "for" if field == "duration" else field


class Action(Section):
    """One action of a scenario: when it begins and ends, and what it does.

    It begins `at` a time [s], or `when` a condition as ``buoy.z > 2 m`` is first true; it ends
    after a time `for` [s] (in Python `duration`), or not at all.
    set: values by unconnected input or tunable parameter; parameters: a file with such values;
    ramp: values that these reach in equal steps `within` a time [s].
    freeze: signals that stay as they are. offset: amounts that are added, by signal. replace: by
    signal, a value, or another output. noise: standard deviations by signal, of numbers drawn anew
    `every` so many seconds from a `seed`. delay: times [s] by signal.
    dropout: signals that are lost, each time with the probability `share`, drawn likewise (always,
    if unsaid); a lost signal gives its last value or zero. broken_line: lines of moorings that
    part.
    """

    model_config = ConfigDict(populate_by_name=True, alias_generator=_key)

    at: Time | None = None
    when: str | None = None
    duration: Time | None = None
    set: Mapping[str, bool | int | float | str] | None = None
    ramp: Mapping[str, Amount] | None = None
    within: Time | None = None
    parameters: str | None = None
    freeze: Names | None = None
    offset: Mapping[str, Amount] | None = None
    replace: Mapping[str, Amount] | None = None
    noise: Mapping[str, Amount] | None = None
    delay: Mapping[str, Time] | None = None
    dropout: Names | None = None
    gives: Literal["last", "zero"] = "last"
    share: Annotated[float, Field(gt=0.0, le=1.0)] | None = None
    seed: int | None = None
    every: Time | None = None
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
        other = [
            key for key in _OPTIONS if key in self.model_fields_set and key not in KINDS[kinds[0]]
        ]
        if other:
            yield f"{kinds[0]!r} has no {other[0]!r}", f"leave {other[0]!r} out"
        for key in ("duration", "within", "every"):
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
        if kinds[0] == "noise" and self.seed is None:
            yield "noise without a seed", "give one, 'seed: 1': the same gives the same numbers"
        if self.seed is not None and self.every is None and "every" in KINDS[kinds[0]]:
            remedy = "give the time between two drawings, 'every: 0.1 s'"
            name = "noise" if kinds[0] == "noise" else "losses at random"
            yield f"{name} without 'every'", remedy
        if kinds[0] == "dropout" and (self.share is None) != (self.seed is None):
            remedy = "give both for losses at random, none for a signal that is always lost"
            yield "a dropout has one of 'share' and 'seed'", remedy
