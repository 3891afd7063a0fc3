"""Dependencies that FMUs do not declare, found by moving their inputs.

Where an FMU declares nothing, each output may depend on every input, and a ring of such FMUs is an
algebraic loop that mostly is none. Which of the outputs in such loops follow which inputs, is seen
in an instance that is thrown away: at three points (after initialisation, and after one and two
steps with all inputs moved) each input is moved, and the outputs are read. First by little, then by
its nominal or its start value, within its range; what is not Real gets another value. An output
that changes, depends; so does one that changes between two readings, and all where the FMU answers
with an error to a value.

Some FMUs compute outputs in steps only. What an input is moved by shows after the next step then,
and no longer when the input is back one step later; what is integrated stays. That is no loop, but
a delay of one step.

Outputs in no loop are tried for that too, and keep the dependencies that are assumed. An output in
a loop that a step leaves as it is, and that setting inputs brings then, is taken to depend on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import networkx as nx

from m4e_fmi.cosim.connections.dependence import PROBED, STEPPED, assumed, resolve
from m4e_fmi.cosim.connections.links import Wiring
from m4e_fmi.cosim.connections.structure import exchange_graph
from m4e_fmi.cosim.exchange.interruption import setting_up
from m4e_fmi.cosim.preparation.trial_instances import Instances, Subject, driven_inputs
from m4e_fmi.cosim.system.start_values import Value
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.worker import Host

SHARES = 1e-3, 1.0
"""By how much an input is moved alone, over its size."""
POINTS = 3
LOST_AGAIN = 0.5
"""The share of a difference that is lost in the second step, where it is not integrated."""


@dataclass(frozen=True)
class Probe:
    """Result of moving inputs: the inputs that each output follows, and how that is known.

    Where it could not be done, `failure` says why.
    """

    needs: Mapping[str, frozenset[str]]
    how: Mapping[str, str]
    failure: str = ""


def probed(
    system: System,
    descriptions: Mapping[str, Description],
    wiring: Wiring,
    hosts: Mapping[str, Host],
) -> tuple[dict[str, Description], list[str]]:
    """The descriptions with what probing has found, and what is to be said of it, line by line."""
    result, told = dict(descriptions), dict[str, list[str]]()
    known: dict[object, Probe] = {}
    unknown = {name: assumed(description) for name, description in descriptions.items()}
    driven = {name: inputs for name, inputs in driven_inputs(wiring).items() if unknown[name]}
    looped = dict(_looped(descriptions, wiring, unknown)) if driven else {}
    for component in system.components:
        if component.name not in driven:
            continue
        description = descriptions[component.name]
        outputs, inputs = looped.get(component.name, ((), ()))
        others = tuple(sorted(unknown[component.name].difference(outputs)))
        start = tuple(sorted((name, str(value)) for name, value in component.start.items()))
        asked = _Asked(outputs, inputs, others, driven[component.name])
        key = description.path, start, component.step_size, asked
        if key not in known:
            new = Instances(component, description, system.simulation, hosts.get(component.name))
            known[key] = _probe(new, description, asked)
        found = known[key]
        rest = frozenset(v.name for v in description.of_causality("input")).difference(inputs)
        needs = {name: follows | rest for name, follows in found.needs.items()}
        result[component.name] = resolve(description, needs, found.how)
        text = _line(found, outputs, f"none of {', '.join(inputs)}" if rest else "no input")
        if text:
            told.setdefault(text, []).append(component.name)
    return result, [
        f"{', '.join(names)}: no dependencies are declared; {text}" for text, names in told.items()
    ]


@dataclass(frozen=True)
class _Asked:
    """Of a component: outputs and inputs in loops; the other outputs, and all connected inputs."""

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    others: tuple[str, ...]
    driven: tuple[str, ...]


def _looped(
    descriptions: Mapping[str, Description],
    wiring: Wiring,
    unknown: Mapping[str, frozenset[str]],
) -> Iterator[tuple[str, tuple[tuple[str, ...], tuple[str, ...]]]]:
    """Components with outputs that are assumed to close a loop: these outputs, and its inputs.

    `unknown` are the outputs of whose dependencies nothing is known.
    """
    graph = exchange_graph(descriptions, wiring)
    found: dict[str, tuple[set[str], set[str]]] = {}
    for loop in nx.strongly_connected_components(graph):
        for port in loop if len(loop) > 1 else ():
            if port.variable in unknown[port.component]:
                inputs = {p.variable for p in graph.predecessors(port) if p in loop}
                outputs, all_inputs = found.setdefault(port.component, (set(), set()))
                outputs.add(port.variable)
                all_inputs |= inputs
    for name, (outputs, inputs) in found.items():
        yield name, (tuple(sorted(outputs)), tuple(sorted(inputs)))


def _line(found: Probe, outputs: Sequence[str], none: str) -> str:
    """A note on a component; empty where no loop depends on it."""
    if found.failure:
        return (
            f"{', '.join(outputs)} may depend on every input ({found.failure}); write them "
            "under `dependencies` of the component"
        )
    texts = []
    for name in outputs:
        needs = sorted(found.needs[name])
        text = f"{name} follows {', '.join(needs) or none}"
        texts.append(text + (" before its next step" if found.how[name] == STEPPED else ""))
    return f"probed, {'; '.join(texts)}" if texts else ""


def _probe(new: Instances, description: Description, asked: _Asked) -> Probe:
    """The result for outputs in loops, and for those that are a step late."""
    if description.once_per_process:
        failure = "its FMU allows one instance only, so that it is not probed"
        return Probe({}, {}, failure if asked.outputs else "")
    every = (*asked.outputs, *asked.others)
    try:
        with setting_up():
            late = _late(new, every, asked.driven)
            needs = _moved_inputs(new, asked.outputs, asked.inputs) if asked.outputs else {}
    except RunError as error:
        return Probe({}, {}, f"probing it failed: {error.message}" if asked.outputs else "")
    late -= {name for name, found in needs.items() if found}
    how = dict.fromkeys(asked.outputs, PROBED) | dict.fromkeys(sorted(late), STEPPED)
    return Probe(needs, how)


def _moved_inputs(
    new: Instances, outputs: Sequence[str], inputs: Sequence[str]
) -> dict[str, frozenset[str]]:
    """The inputs that each output follows."""
    needs: dict[str, set[str]] = {name: set() for name in outputs}
    count = len(inputs)
    with new.instance() as instance:
        subject = Subject(instance, outputs, inputs)
        values, back, fresh = subject.start, list[Value](), list[Value]()
        for point in range(POINTS):
            subject.set(values)
            still = subject.read()
            for output, *seen in zip(outputs, back, fresh, still, strict=False):
                if not _differ(seen[0], seen[1]) and _differ(seen[1], seen[2]):
                    needs[output].update(inputs)  # setting brings what the step has not shown
            sign = -1.0 if point % 2 else 1.0
            for (column, name), share in product(enumerate(inputs), SHARES):
                only = [sign * share * (k == column) for k in range(count)]
                subject.set(subject.moved(only, values))
                there = subject.read()
                subject.set(values)
                back = subject.read()
                for output, *seen in zip(outputs, still, there, back, strict=True):
                    if any(_differ(seen[0], value) for value in seen[1:]):
                        needs[output].add(name)
            if point + 1 < POINTS:
                values = subject.moved_together(sign)
                subject.set(values)
                subject.step(new.step)
                fresh = subject.read()
    return {name: frozenset(found) for name, found in needs.items()}


def _differ(a: Value, b: Value) -> bool:
    return a != b and not (a != a and b != b)  # two that are nan are the same


def _distance(a: Value, b: Value) -> float:
    """How far two values are apart; 1 if they are no numbers, and differ."""
    return abs(a - b) if isinstance(a, float) and isinstance(b, float) else float(a != b)


def _late(new: Instances, outputs: Sequence[str], inputs: Sequence[str]) -> set[str]:
    """Outputs that follow some input in the step after it is moved, and in no other.

    Nor before the next step, when it is back: what follows it at once is not late.
    """

    def trajectory(share: float) -> tuple[list[Value], ...]:
        """Outputs after a step with the inputs moved, with the inputs back, and a step later."""
        with new.instance() as instance:
            subject = Subject(instance, outputs, inputs)
            subject.set(subject.moved([share] * len(inputs)))
            subject.step(new.short_step)
            first = subject.read()
            subject.set(subject.start)
            still = subject.read()
            subject.step(new.short_step)
            return first, still, subject.read()

    moved, unmoved = trajectory(SHARES[0]), trajectory(0.0)
    found = set()
    for name, *values in zip(outputs, *moved, *unmoved, strict=True):
        first, still, second = (
            _distance(a, b) for a, b in zip(values[:3], values[3:], strict=True)
        )
        lost = (1.0 - LOST_AGAIN) * first
        if second < lost <= still:
            found.add(name)
    return found
