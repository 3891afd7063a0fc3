"""Warnings and errors that the FMUs of a run log: each kind of message once, with its count.

Messages of one component that differ in numbers only are of one kind. Its first text, the number of
messages and the times of the first and the last are kept. What a million messages cost is bounded:
so many kinds are kept of a component, and so many characters of a text; the rest is counted.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial

from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.fmu.importer.messages import STATUS, Listener
from m4e_fmi.signals import is_ending

KINDS = 20
"""Kinds of messages that are kept of a component; further ones are counted together."""
LONGEST = 400
"""Characters of a text that are kept."""
FURTHER = f"further messages: only the first {KINDS} kinds are listed"
SILENT = "fmi2DoStep returned Warning, and the FMU logged nothing"
"""Said of steps of the FMU, of which algorithms make several in a step of the system."""
_ESCAPES = re.compile(r"\x1b(\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(\x07|\x1b\\)?|.)?")
_NUMBER = re.compile(r"(?<![\w.])[-+]?(0x[0-9a-f]+|(\d+\.?\d*|\.\d+)(e[-+]?\d+)?)", re.IGNORECASE)

Warn = Callable[[str], None]
"""Called with a line that a person should read now."""


@dataclass(frozen=True)
class FmuMessage:
    """One kind of message: `text` is the first of them, `first` and `last` are times [s].

    `status` is FMI's word in small letters: warning, discard, error, fatal or pending. The times
    are those at which the steps began in which the messages came; `steps` is how many steps of the
    system these were, 0 where `count` is one of steps of the FMU.
    """

    component: str
    status: str
    text: str
    count: int
    first: float
    last: float
    steps: int = 0

    def __str__(self) -> str:
        if self.count == 1:
            when = f"{self.status} at t = {self.first:.9g} s"
        else:
            until = f" to {self.last:.9g} s" if self.last != self.first else ""
            times = f"{self.count} times"
            if not self.steps:
                times = f"in {self.count} steps of the FMU"
            elif self.steps < self.count:
                times += f" in {self.steps} step{'s' * (self.steps > 1)} of the system"
            when = f"{self.status}, {times}, t = {self.first:.9g} s{until}"
        return f"{self.component}, {when}: {self.text}"


@dataclass
class Kind:
    """The first message of a kind, how many there were, and the time [s] of the last."""

    first: FmuMessage
    count: int
    last: float
    steps: int = 1


Kinds = dict[str, dict[tuple[int, str], Kind]]
"""By component, all kinds by their status and text, in which numbers do not count."""


class Journal:
    """Collects the messages of a run; `warn` is called with the first of each kind at once.

    `clock` gives the present simulated time [s].
    """

    def __init__(self, warn: Warn | None, clock: Callable[[], float]) -> None:
        self._warn = warn
        self.clock = clock
        self._kinds: Kinds = {}
        self._failure: BaseException | None = None

    def listener(self, component: str) -> Listener:
        """The listener for messages of a component."""
        self._kinds[component] = {}
        return partial(self.add, component)

    def add(self, component: str, status: int, text: str) -> None:
        """Count a message of this status, more than OK, that comes now.

        An FMU in which a signal has raised may take it for its own failure: that is no message.
        """
        if is_ending():
            return
        now, kinds = self.clock(), self._kinds[component]
        told = cleaned(text).removeprefix(f"{component}: ")
        key = status, _NUMBER.sub("#", told)
        if key not in kinds and len(kinds) >= KINDS:
            key, told = (status, FURTHER), FURTHER
        known = kinds.get(key)
        if known:
            known.steps += now != known.last
            known.count, known.last = known.count + 1, now
            return
        word = STATUS.get(status, "pending").lower()
        kinds[key] = kind = Kind(FmuMessage(component, word, told, 1, now, now), 1, now)
        self._tell(str(kind.first))

    def notice(self, line: str) -> None:
        """Tell of a call that takes long."""
        self._tell(line)

    def snapshot(self) -> Kinds:
        """All kinds so far, as they are now."""
        return {
            component: {key: replace(kind) for key, kind in kinds.items()}
            for component, kinds in self._kinds.items()
        }

    def restore(self, kinds: Kinds, warn: Warn | None) -> None:
        """Go on after these kinds, which have been told of; `warn` is called with new ones."""
        self._warn = warn
        self._kinds = {component: dict(known) for component, known in kinds.items()}

    def _tell(self, line: str) -> None:
        """Call `warn`; what it raises waits for `check`, as the caller is an FMU."""
        try:
            if self._warn and not self._failure:
                self._warn(line)
        except BaseException as error:  # noqa: BLE001  raised again by `check`
            self._failure = error

    def check(self) -> None:
        """Raise what `warn` has raised, if it has."""
        if self._failure:
            failure, self._failure = self._failure, None
            self._warn = None
            raise failure

    def messages(self, instances: Iterable[Instance]) -> tuple[FmuMessage, ...]:
        """All kinds, in the order of their first times; also warnings of steps without words."""
        told = [
            replace(kind.first, count=kind.count, last=kind.last, steps=kind.steps)
            for kinds in self._kinds.values()
            for kind in kinds.values()
        ]
        loud = {message.component for message in told}
        silent = [
            FmuMessage(i.name, "warning", SILENT, i.warned.count, i.warned.first, i.warned.last)
            for i in instances
            if i.warned.count and i.name not in loud
        ]
        return tuple(sorted((*told, *silent), key=lambda one: one.first))


def cleaned(text: str) -> str:
    """A text in one line, without control characters, cut where it is too long."""
    plain = _ESCAPES.sub("", text) if "\x1b" in text else text
    if not plain.isprintable():
        plain = "".join(c if c.isprintable() else " " for c in plain)
    line = " ".join(plain.split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 2]} …"
