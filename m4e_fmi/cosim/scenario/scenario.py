"""A scenario in a run: its actions act at communication points, after the exchange there.

First the actions begin and end that are due: their times, which steps of the master meet, have
come, or their conditions hold; so have the times of new random numbers. Then variables are set, and
what takers of signals are given follows anew: by all active actions on a signal, in the order of
the file. Where this changes anything, the network exchanges again, so that the point is consistent
with it.

All that an action knows of the past is in a snapshot; random numbers follow from the time. So steps
may be taken back and repeated.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from m4e_fmi.cosim.scenario.plan import COMPONENT, PlannedAction, Planner, Setting
from m4e_fmi.cosim.system.simulation import NEVER, NS_PER_SECOND, nanoseconds
from m4e_fmi.cosim.system.start_values import Value
from m4e_fmi.cosim.wiring.links import PLAIN, Bond, InputScales, Link, Port
from m4e_fmi.cosim.wiring.prepared import Prepared


@dataclass(frozen=True)
class ScenarioSnapshot:
    """When each action has begun and ended [ns], what variables had, memories, scales of inputs.

    `kept` are the values of each variable that actions set, `memories` are those of all effects,
    signal by signal; `scales` are factor and offset by signal.
    """

    began: tuple[int | None, ...]
    ended: tuple[int | None, ...]
    kept: tuple[tuple[Value, ...], ...]
    memories: tuple[float | None, ...]
    scales: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Acted:
    """Changes that actions have made at a point.

    `ports` are the variables of actions that have begun or ended, `changes` the
    variables set by component, and `again` tells to exchange anew.
    """

    ports: tuple[Port, ...]
    changes: Mapping[str, set[str]]
    again: bool


class _Running:
    """An action in a run: when it `began` and `ended` [ns]."""

    def __init__(self, planned: PlannedAction) -> None:
        self.planned = planned
        self.began: int | None = None
        self.ended: int | None = None
        self.port = Port(COMPONENT, planned.name)

    @property
    def active(self) -> bool:
        return self.began is not None and self.ended is None

    @property
    def next(self) -> int:
        """The time [ns] of its beginning or end; NEVER while unknown."""
        if self.began is None:
            return NEVER if self.planned.at is None else self.planned.at
        duration = self.planned.duration
        return NEVER if duration is None or self.ended is not None else self.began + duration

    def __str__(self) -> str:
        name, planned = self.planned.name, self.planned
        if self.began is None:
            why = f"when {planned.condition.text}" if planned.condition else ""
            why = why or f"at {(planned.at or 0) / NS_PER_SECOND:.9g} s"
            return f"{name}: never happened ({why})"
        begin = f"{name}: from t = {self.began / NS_PER_SECOND:.9g} s"
        end = "on" if self.ended is None else f"to {self.ended / NS_PER_SECOND:.9g} s"
        values = ", ".join(map(str, planned.settings))
        return f"{begin} {end}: {values}" if values else f"{begin} {end}"


class _Variable:
    """A variable `port` that actions set: it has the value of the one that began last.

    `kept` are the value before all that are active, the value given now, and for each action the
    value that there was when it began.
    """

    def __init__(self, port: Port) -> None:
        self.port = port
        self.settings: list[tuple[_Running, Setting]] = []
        self.kept: tuple[Value, ...] = ()

    def give(self, now: int, read: Callable[[Port], Value]) -> Value | None:
        """The value to set at the time `now` [ns]; None if it stays as it is."""
        active = [k for k, (action, _) in enumerate(self.settings) if action.active]
        if not active:
            kept, self.kept = self.kept, ()
            return kept[0] if kept and kept[0] != kept[1] else None
        if not self.kept:
            present = read(self.port)
            self.kept = (present,) * (2 + len(self.settings))
        former, given, *begins = self.kept
        for k, (action, _) in enumerate(self.settings):
            begins[k] = given if action.began == now else begins[k]
        last = max(active, key=lambda k: (self.settings[k][0].began or 0, k))
        action, setting = self.settings[last]
        value = setting.value_after(now - (action.began or 0), begins[last])
        self.kept = (former, value, *begins)
        return None if value == given else value


@dataclass
class _Effect:
    """An action on one taker of a signal; `memory` is the value that it has frozen."""

    action: _Running
    kind: str
    amount: float
    memory: float | None = None


class _Signal:
    """A link on whose signal actions act, with their effects in the order of the file."""

    def __init__(self, link: Link, scales: InputScales, place: int) -> None:
        self.ends, self.scales, self.place = link.ends, scales, place
        self.plain = PLAIN if link.is_plain else (link.factor, link.offset)
        self.now = self.plain
        self.effects: list[_Effect] = []
        self.scales.follow(self.ends)

    def give(self, source: float) -> bool:
        """Let the actions act on the `source`'s value; True if the taker is given anything else."""
        factor, offset = self.plain
        for effect in self.effects:
            if not effect.action.active:
                continue
            if effect.kind == "offset":
                offset = offset + effect.amount
            elif effect.kind == "replace":
                factor, offset = 0.0, effect.amount
            else:
                if effect.memory is None:
                    effect.memory = factor * source + offset
                factor, offset = 0.0, effect.memory
        return self.scale((factor, offset))

    def scale(self, scale: tuple[float, float]) -> bool:
        """Let the taker have this factor and offset; True if it had others."""
        changed, self.now = scale != self.now, scale
        if changed:
            self.scales.set(self.ends, *scale)
        return changed


class Scenario:
    """The actions of a prepared system's scenario on its `instances`; falsy if there are none.

    `place` gives the index of a link's value among all that are exchanged, `read` the present value
    of ``component.variable``.

    `cells` (n_actions,), int64, are 1 for active actions, in the order of `names`. `late` are the
    variables of those that may have been due anywhere in the last step.
    """

    def __init__(
        self,
        prepared: Prepared,
        instances: Mapping[str, Any],
        place: Callable[[Link], int],
        read: Callable[[str], float],
    ) -> None:
        planned = Planner(prepared.system, prepared.descriptions, prepared.wiring).actions()
        self._actions = [_Running(action) for action in planned]
        self._instances, self._read = instances, read
        self.names = tuple(action.name for action in planned)
        self.cells = np.zeros(len(planned), dtype=np.int64)
        self._signals: dict[tuple[Port, Port], _Signal] = {}
        self._variables: dict[Port, _Variable] = {}
        self.late: set[Port] = set()
        for action in self._actions:
            for setting in action.planned.settings:
                variable = self._variables.setdefault(setting.port, _Variable(setting.port))
                variable.settings.append((action, setting))
            for effect in action.planned.effects:
                link = effect.link
                if link.ends not in self._signals:
                    scales = instances[link.target.component].scales
                    self._signals[link.ends] = _Signal(link, scales, place(link))
                self._signals[link.ends].effects.append(_Effect(action, effect.kind, effect.amount))

    def __bool__(self) -> bool:
        return bool(self._actions)

    def with_watched(
        self, recorded: Mapping[str, Collection[str]]
    ) -> Mapping[str, Collection[str]]:
        """`recorded` variables by component, and those of conditions."""
        found = {component: set(names) for component, names in recorded.items()}
        for action in self._actions:
            if action.planned.condition:
                port = action.planned.condition.port
                found.setdefault(port.component, set()).add(port.variable)
        return found

    def next(self, now: int) -> int:
        """The next time [ns] after `now` of a beginning or an end; NEVER if unknown."""
        return min((a.next for a in self._actions if a.next > now), default=NEVER)

    def act(self, time: float, values: np.ndarray) -> Acted:
        """Act at the present point, at `time` [s]; inputs and variables of FMUs change.

        `values` (n,) are all that are exchanged, in their units.
        """
        now = nanoseconds(time)
        ports = tuple(action.port for action in self._turning(now))
        changes: dict[str, set[str]] = {}
        for port, variable in self._variables.items():
            value = variable.give(now, self._value)
            if value is not None:
                self._instances[port.component].set_values({port.variable: value})
                changes.setdefault(port.component, set()).add(port.variable)
        given = [signal.give(float(values[signal.place])) for signal in self._signals.values()]
        self._note()
        return Acted(ports, changes, again=bool(changes) or any(given))

    def _turning(self, now: int) -> list[_Running]:
        """The actions that begin or end now; they are noted."""
        turning: list[_Running] = []
        self.late.clear()
        for action in self._actions:
            due = action.next
            if action.active and due <= now:
                action.ended = now
            elif action.began is None and (due <= now or self._holds(action)):
                action.began = now
            else:
                continue
            if due != now:
                self.late.add(action.port)
            turning.append(action)
        return turning

    def _holds(self, action: _Running) -> bool:
        asked = action.planned.condition
        return asked is not None and asked.compare(self._read(str(asked.port)), asked.value)

    def _value(self, port: Port) -> Value:
        return self._instances[port.component].values([port.variable])[0]

    def _note(self) -> None:
        self.cells[:] = [action.active for action in self._actions]

    def untouched(self, bonds: Iterable[Bond]) -> tuple[Bond, ...]:
        """The bonds none of whose signals is changed by an action: energy balances hold there."""

        def is_touched(bond: Bond) -> bool:
            links = [k for axis in bond.axes for k in (axis.force, axis.velocity, axis.position)]
            inputs = [link.ends for link in links if link is not None]
            return any(ends in self._signals for ends in inputs)

        return tuple(bond for bond in bonds if not is_touched(bond))

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the actions whose values change, but not within a step: errors of first order.

        They are ramps.
        """
        planned = (action.planned for action in self._actions)
        return tuple(a.name for a in planned if any(setting.within for setting in a.settings))

    def report(self) -> tuple[str, ...]:
        """When each action began and ended, one line each."""
        return tuple(map(str, self._actions))

    def snapshot(self) -> ScenarioSnapshot:
        """All that later steps depend on, but for what FMUs know."""
        signals = self._signals.values()
        return ScenarioSnapshot(
            tuple(action.began for action in self._actions),
            tuple(action.ended for action in self._actions),
            tuple(variable.kept for variable in self._variables.values()),
            tuple(effect.memory for signal in signals for effect in signal.effects),
            tuple(signal.now for signal in signals),
        )

    def restore(self, snapshot: ScenarioSnapshot) -> None:
        """Go on as from where the snapshot was taken."""
        for k, action in enumerate(self._actions):
            action.began, action.ended = snapshot.began[k], snapshot.ended[k]
        for variable, kept in zip(self._variables.values(), snapshot.kept, strict=True):
            variable.kept = kept
        memories = iter(snapshot.memories)
        for signal, scale in zip(self._signals.values(), snapshot.scales, strict=True):
            for effect in signal.effects:
                effect.memory = next(memories)
            signal.scale(scale)
        self._note()
