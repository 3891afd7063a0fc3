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


@dataclass(frozen=True)
class Ending:
    """End of a process: by itself with code 0 or another, by a signal, or for a call that hangs.

    The `message` names the last call.
    """

    kind: Literal["done", "ended", "crash", "hang"]
    message: str


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
        number, text = last_call(self._journal)
        if number != self._number:
            self._number, self._changed = number, now
        call = text or "the first call"
        code = self._process.exitcode
        if code is not None:
            kill_children(self._pid)
            if code < 0:
                message = f"the process was ended by {signal.Signals(-code).name} in {call}"
                return Ending("crash", message)
            message = f"the process ended with code {code} after {call}"
            return Ending("ended" if code else "done", message)
        if now - self._changed > self._call_limit:
            message = f"{call} did not return within {self._call_limit:g} s"
        elif now - self.began > self._limit:
            message = f"not finished after {self._limit:g} s, in {call}"
        else:
            return None
        self.kill()
        self._process.join()
        return Ending("hang", message)

    def kill(self) -> None:
        """End the process at once, and those that it has started."""
        kill(self._pid)


def _apart(target: Callable[..., object], *arguments: object) -> None:
    set_apart()
    target(*arguments)
