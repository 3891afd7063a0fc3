"""The beginning of a run at a checkpoint of another: its states, or the same steps once more."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.cosim.checkpoint.container import Parts, read_checkpoint, results_of
from m4e_fmi.cosim.checkpoint.fmu_states import deserialize
from m4e_fmi.cosim.checkpoint.identity import check_identity
from m4e_fmi.cosim.checkpoint.state import Head, Saved
from m4e_fmi.cosim.exchange.fmu_log import Warn
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.master.checkpoints import HEAD, SAVED, exchanged
from m4e_fmi.cosim.results.writer import Begun
from m4e_fmi.errors import InputError, RunError

if TYPE_CHECKING:
    from m4e_fmi.cosim.master.master import Master


@dataclass(frozen=True)
class Resumed:
    """A checkpoint at `path` at which a run begins; it is read only.

    Where the run is `replayed`, it makes all steps up to there once more, for the reason given.
    `warn` hears what FMUs log; from there on, if it is not replayed.
    """

    path: Path
    head: Head
    replayed: str
    warn: Warn | None
    _parts: Parts

    @classmethod
    def at(cls, path: Path, *, check: bool, watched: bool, warn: Warn | None) -> Resumed:
        """The checkpoint at `path`; a run with a `check`, or `watched`, may need all of its steps.

        InputError if there is none, or if it is damaged.
        """
        results_of(path)
        parts = read_checkpoint(path)
        head = parts.part(HEAD, Head)
        why = head.without
        if watched and not head.watched:
            why = why or "observers may read outputs that the checkpoint does not have"
        if check:
            why = why or "the check at half the step compares all points"
        return cls(path, head, why, warn, parts)

    @property
    def at_once(self) -> Warn | None:
        """The one that hears what FMUs log when they are made: nobody, if that is known."""
        return self.warn if self.replayed else None

    @property
    def rows(self) -> Begun:
        """The rows with which the results begin."""
        head, results = self.head, results_of(self.path)
        return Begun(results, head.rows, head.last, head.digest, replayed=bool(self.replayed))

    def check(self, identity: Mapping[str, str], stop_time: float) -> None:
        """InputError if the run has another `identity`, or ends before the checkpoint [s]."""
        check_identity(str(self.path), self.head.identity, identity)
        if stop_time < self.head.time:
            message = f"the checkpoint is at t = {self.head.time:.9g} s, after the stop time"
            remedy = f"take a stop_time of {self.head.time:.9g} s or more"
            raise InputError.single(message, remedy, str(self.path))

    def tell(self, tell: Callable[[str], None] | None) -> None:
        """Say from where the run goes on, and if it makes steps once more, why."""
        if tell is None:
            return
        time = f"t = {self.head.time:.9g} s"
        if self.replayed:
            tell(f"the run is made again from its start to {time}, as {self.replayed}")
        else:
            tell(f"the run goes on at {time}")

    def bring_texts(self, network: Network) -> None:
        """Give texts the places that they had; RunError if the run's own start has others."""
        for place, text in enumerate(self.head.texts):
            if network.discrete.texts.place(text) != place:
                raise self._different("texts")

    def bring(self, master: Master) -> None:
        """Bring a run at its start time to the checkpoint, unless it is replayed."""
        if self.replayed:
            return
        live = {"master": master}
        saved = self._parts.part(SAVED, Saved, live)
        try:
            if saved.state.time != self.head.time:
                raise ValueError(f"a state of t = {saved.state.time:.9g} s")
            deserialize(master.network, saved)
            master.restore(saved.state)
            master.remember(saved.memory, self.warn)
        except (ValueError, TypeError, KeyError, IndexError, AssertionError) as error:
            message = f"is damaged: {type(error).__name__}: {error}"
            raise InputError.single(message, "run again from the start", str(self.path)) from error

    def rest(self, master: Master) -> float:
        """Steps up to the checkpoint of a run that is replayed; infinite behind it."""
        rest = self.head.steps - master.steps
        return rest if self.replayed and rest > 0 else math.inf

    def compare(self, master: Master) -> None:
        """RunError if the run is at the checkpoint, and other values are exchanged there."""
        if not self.replayed or master.steps != self.head.steps:
            return
        if master.network.time != self.head.time:
            raise self._different("times of the steps")
        found, kept = exchanged(master.network), self.head.exchanged
        outputs = (*master.network.outputs, *master.network.discrete.outputs)
        for one, other in ((found.values, kept.values), (found.cells, kept.cells)):
            if one.shape != other.shape:
                raise self._different("other outputs")
            places = np.flatnonzero(one.view(np.int64) != other.view(np.int64))
            if len(places):
                first = places[0] + (0 if one is found.values else len(found.values))
                raise self._different(str(outputs[first]))

    def _different(self, what: str) -> RunError:
        return RunError(
            f"the run made again up to the checkpoint at t = {self.head.time:.9g} s has other bits "
            f"there than before ({what}): an FMU is not deterministic, or not as it was",
            "run again from the start, without --resume",
        )
