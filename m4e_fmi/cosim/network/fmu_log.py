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

from m4e_fmi.cosim.network.instance import Instance
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
    are those at which the steps began in which the messages came.
    """

    component: str
    status: str
    text: str
    count: int
    first: float
    last: float

    def __str__(self) -> str:
        if self.count == 1:
            when = f"{self.status} at t = {self.first:.9g} s"
        else:
            until = f" to {self.last:.9g} s" if self.last != self.first else ""
            when = f"{self.status}, {self.count} times, t = {self.first:.9g} s{until}"
        return f"{self.component}, {when}: {self.text}"


Kinds = dict[str, dict[tuple[int, str], FmuMessage]]
"""By component, and by status and text without numbers: the first message, with counts, times."""


class Journal:
    """All that the FMUs of a run log; `warn` is called with the first of each kind at once.

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
        plain = cleaned(text).removeprefix(f"{component}: ")
        key = status, _NUMBER.sub("#", plain)
        if key not in kinds and len(kinds) >= KINDS:
            key, plain = (status, FURTHER), FURTHER
        if known := kinds.get(key):
            kinds[key] = replace(known, count=known.count + 1, last=now)
            return
        word = STATUS.get(status, "pending").lower()
        kinds[key] = FmuMessage(component, word, plain, 1, now, now)
        self.notice(str(kinds[key]))

    def notice(self, line: str) -> None:
        """Call `warn`; what it raises waits for `check`, as the caller may be an FMU."""
        try:
            if self._warn and not self._failure:
                self._warn(line)
        except BaseException as error:  # noqa: BLE001  raised again by `check`
            self._failure = error

    def snapshot(self) -> Kinds:
        """All kinds so far, as they are now."""
        return {component: dict(kinds) for component, kinds in self._kinds.items()}

    def restore(self, kinds: Kinds, warn: Warn | None) -> None:
        """Continue after these kinds, which were reported; `warn` is called with new ones."""
        self._warn = warn
        self._kinds = {component: dict(known) for component, known in kinds.items()}

    def check(self) -> None:
        """Raise what `warn` has raised, if it has."""
        if self._failure:
            failure, self._failure = self._failure, None
            self._warn = None
            raise failure

    def messages(self, instances: Iterable[Instance]) -> tuple[FmuMessage, ...]:
        """All kinds, in the order of their first times; also warnings of steps without words."""
        found = [message for kinds in self._kinds.values() for message in kinds.values()]
        loud = {message.component for message in found}
        silent = [
            FmuMessage(i.name, "warning", SILENT, i.warned.count, i.warned.first, i.warned.last)
            for i in instances
            if i.warned.count and i.name not in loud
        ]
        return tuple(sorted((*found, *silent), key=lambda one: one.first))


def cleaned(text: str) -> str:
    """A text in one line, without control characters, cut where it is too long."""
    plain = _ESCAPES.sub("", text) if "\x1b" in text else text
    if not plain.isprintable():
        plain = "".join(c if c.isprintable() else " " for c in plain)
    line = " ".join(plain.split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 2]} …"
