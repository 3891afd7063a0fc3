"""A process that calls an FMU and writes a journal of its calls: crashes and hangs are reported.

The process that watches calls no FMU itself, so nothing can happen to it.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Literal

from m4e_fmi.fmu.importer.call_journal import last_call
from m4e_fmi.fmu.importer.worker.keeper import kill, kill_children, set_apart

UNASKED_LIMIT = 5.0
"""Seconds for a call that the standard forbids importers to make."""


@dataclass(frozen=True)
class Ending:
    """End of a process: by itself with code 0 or another, by a signal, or for a call that hangs.

    The `message` names the last call, which no importer may make if it was `unasked`.
    """

    kind: Literal["done", "ended", "crash", "hang"]
    message: str
    unasked: bool


class WatchedProcess:
    """A process that runs ``target(*arguments)``, with its calls in the file `journal`.

    It is killed when a call takes longer than `call_limit`, or all of it longer than `limit` [s].
    """

    def __init__(
        self,
        target: Callable[..., object],
        arguments: tuple[object, ...],
        journal: Path,
        *,
        call_limit: float,
        limit: float,
    ) -> None:
        self._journal, self._call_limit, self._limit = journal, call_limit, limit
        self.began = self._changed = time.monotonic()
        self._number = 0
        if hasattr(os, "fork"):
            make = multiprocessing.get_context("fork").Process
        else:
            make = multiprocessing.get_context("spawn").Process
        self._process: BaseProcess = make(target=_apart, args=(target, *arguments), daemon=True)
        self._process.start()
        assert self._process.pid
        self._pid = self._process.pid

    def ending(self) -> Ending | None:
        """How the process ended; None while it runs. To be asked until it is there."""
        now = time.monotonic()
        last = last_call(self._journal)
        if last.number != self._number:
            self._number, self._changed = last.number, now
        call = last.text or "the first call"
        code = self._process.exitcode
        if code is not None:
            kill_children(self._pid)
            if code < 0:
                message = f"the process was ended by {signal.Signals(-code).name} in {call}"
                return Ending("crash", message, last.unasked)
            message = f"the process ended with code {code} after {call}"
            return Ending("ended" if code else "done", message, last.unasked)
        limit = min(self._call_limit, UNASKED_LIMIT) if last.unasked else self._call_limit
        if now - self._changed > limit:
            message = f"{call} did not return within {limit:g} s"
        elif now - self.began > self._limit:
            message = f"not finished after {self._limit:g} s, in {call}"
        else:
            return None
        self.kill()
        self._process.join()
        return Ending("hang", message, last.unasked)

    def kill(self) -> None:
        """End the process at once, and those that it has started."""
        kill(self._pid)


def _apart(target: Callable[..., object], *arguments: object) -> None:
    set_apart()
    target(*arguments)
