"""The outputs of an FMU at rest: its inputs held until nothing changes any more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.cosim.exchange.interruption import quiet, setting_up
from m4e_fmi.cosim.exchange.operations import Get
from m4e_fmi.cosim.exchange.schedule import Schedule
from m4e_fmi.cosim.preparation.trial_instances import Instances, stepped
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.messages import Listener
from m4e_fmi.fmu.importer.reading import Variable

STEPS, BRIEF = 128, 16
"""Steps with held inputs, of which outputs may not change in the second half; doubled until they do
not. `BRIEF` of an FMU that is at rest from its start at a point nearby."""
MOST_STEPS = 16384
"""Steps after which an FMU that still changes is given up."""
TOLERANCE = 1e-5
"""Change that is none, over the largest output of the same unit, or the nominal value."""
SWING = TOLERANCE**0.5
"""Swing, in the same way, about a mean that is the rest: what is not linear moves the mean of a
swing s by s² of its size, which is `TOLERANCE` then."""


@dataclass(frozen=True)
class Rest:
    """Outputs at rest, `values` (n,) in the FMU's units, reached after `time` [s] and some `steps`.

    Without steps it is the start itself: nothing changed after it. With a `swing` [1], over the
    sizes of outputs, they are the mean of an oscillation that is left.
    """

    values: np.ndarray
    steps: int = 0
    time: float = 0.0
    swing: float = 0.0


class AtRest:
    """The Real `outputs` of new instances of a component's FMU at rest, for values of inputs."""

    def __init__(self, new: Instances, outputs: Sequence[Variable]) -> None:
        self._new, self.outputs = new, outputs
        units = np.array([v.unit for v in outputs], dtype=str)
        self._alike = units[:, None] == units
        self._nominal = np.array([v.nominal for v in outputs])

    def largest(self, values: np.ndarray) -> np.ndarray:
        """The largest (n,) of `values` (n,) of outputs of the same unit, in the FMU's units."""
        return np.max(np.where(self._alike, np.abs(values), 0.0), axis=1, initial=0.0)

    def sizes(self, values: np.ndarray) -> np.ndarray:
        """The sizes (n,) of outputs `values` (n,), in the FMU's units."""
        return np.maximum(self.largest(values), self._nominal)

    def at(
        self, inputs: Mapping[str, float], *, brief: bool = False, listener: Listener | None = None
    ) -> Rest:
        """The rest with these `inputs`, in the FMU's units.

        With `brief`, fewer steps show that the start is at rest. RunError if it does not settle, or
        the FMU fails.
        """
        with (
            setting_up(),
            quiet(),
            self._new.instance(inputs, suffix="", listener=listener) as instance,
        ):
            names, view = tuple(v.name for v in self.outputs), np.zeros(len(self.outputs))
            schedule = Schedule([Get(instance, names, view)] if names else [])

            def read() -> np.ndarray:
                schedule.run(instance.time)
                return view.copy()

            rows, count = [read()], BRIEF if brief else STEPS
            while True:
                try:
                    while len(rows) <= count:
                        stepped(instance, self._new.step)
                        rows.append(read())
                except RunError as error:
                    how = f"while {instance.name} was brought to rest, its inputs held"
                    remedy = f"{error.remedy}; or keep it open (--open {instance.name})"
                    raise RunError(f"{how}: {error.message}", remedy) from error
                seen = np.array(rows)
                limits = TOLERANCE * self.sizes(seen[-1])
                if (np.ptp(seen, axis=0) <= limits).all():
                    return Rest(seen[0])
                change = np.ptp(seen[count // 2 :], axis=0)
                if count >= STEPS and (change <= limits).all():
                    return Rest(seen[-1], count, count * self._new.step)
                if count >= STEPS and _is_steady(seen, limits):
                    mean, swing = _mean(seen[count // 2 :]), float(np.max(change / limits))
                    return Rest(mean, count, count * self._new.step, TOLERANCE * swing)
                if count >= MOST_STEPS:
                    raise self._restless(instance, count, change, change / limits)
                count *= 2

    def _restless(
        self, instance: Instance, count: int, change: np.ndarray, share: np.ndarray
    ) -> RunError:
        """The error of an FMU with outputs that `change` (n,), in its units, or by `share` (n,)."""
        order = np.argsort(-share)[:3]
        moving = ", ".join(
            f"{v.name} by {change[k]:.3g} {v.unit}".rstrip()
            for k in order
            if share[k] > 1.0 and (v := self.outputs[k])
        )
        time = count * self._new.step
        message = (
            f"{instance.name} ({instance.description.path.name}): it does not settle while its "
            f"inputs are held: in the second half of {count} steps ({time:g} s) still change "
            f"{moving}"
        )
        return RunError(message, f"keep it open (--open {instance.name})")


def _is_steady(seen: np.ndarray, limits: np.ndarray) -> bool:
    """True if outputs only swing, by little, about a mean that does not change.

    `seen` (s + 1, n) are the outputs over s steps, `limits` (n,) the changes that are none, in
    their units. The means of the second quarter and of both halves of the second half agree, and
    the swing does not grow.
    """
    quarter = len(seen) // 4
    before, first, second = (seen[k * quarter : (k + 1) * quarter] for k in (1, 2, 3))
    means = np.array([_mean(part) for part in (before, first, second)])
    swings = [np.ptp(part, axis=0) for part in (before, first, second)]
    is_small = (swings[2] <= SWING / TOLERANCE * limits).all()
    is_growing = (swings[2] > np.maximum(swings[0], swings[1]) + limits).any()
    return bool(is_small and not is_growing and (np.ptp(means, axis=0) <= limits).all())


def _mean(part: np.ndarray) -> np.ndarray:
    """The mean (n,) of rows (s, n), by Hann's window: parts of a period hardly count."""
    weights = np.hanning(len(part) + 2)[1:-1]
    return weights @ part / weights.sum()
