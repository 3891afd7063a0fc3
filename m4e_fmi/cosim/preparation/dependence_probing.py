"""Dependencies that FMUs do not declare, found by moving their inputs.

If an FMU declares nothing, each output may depend on every input, and a ring of such FMUs seems to
be an algebraic loop, mostly wrongly. Dependencies of the outputs in such loops are measured
in a temporary instance: at three points (after initialisation, and after one and two
steps with all inputs moved) each input is moved, and the outputs are read. It moves first by
little, then by its nominal or its start value, within its range; inputs that are not Real get
another value. An output depends on an input if it changes, if it changes between two readings, or
if the FMU answers with an error to a value.

Some FMUs compute outputs in steps only. The change of an input then shows after the next step, and
disappears one step after the input is back; the change of an integral stays. That is not a loop,
but a delay of one step.

Outputs in no loop are tested for that, too, and keep their assumed dependencies. An output in
a loop depends on the inputs if a step does not change it, but setting the inputs then does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import networkx as nx

from m4e_fmi.cosim.preparation.trial_instances import Instances, Subject, Trials, driven_inputs
from m4e_fmi.cosim.system.start_values import Value
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Wiring
from m4e_fmi.cosim.wiring.structure import PROBED, STEPPED, assumed, exchange_graph, resolve
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.worker import Host

SHARES = 1e-3, 1.0
"""By how much an input is moved alone, over its size."""
POINTS = 3
LOST_AGAIN = 0.5
"""The share of a difference that is lost in the second step, where it is not integrated."""


@dataclass(frozen=True)
class Dependencies:
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
    """The descriptions with the dependencies found by probing, and lines that report on it."""
    result, trials = dict(descriptions), Trials(system, descriptions, hosts)
    unknown = {name: assumed(description) for name, description in descriptions.items()}
    driven = {name: inputs for name, inputs in driven_inputs(wiring).items() if unknown[name]}
    looped = _looped(descriptions, wiring, unknown) if driven else {}
    for component in (c for c in system.components if c.name in driven):
        description = descriptions[component.name]
        outputs, inputs = looped.get(component.name, ((), ()))
        others = tuple(sorted(unknown[component.name].difference(outputs)))
        found = trials.ask(component, _probe, outputs, inputs, others, driven[component.name])
        rest = frozenset(v.name for v in description.of_causality("input")).difference(inputs)
        needs = {name: follows | rest for name, follows in found.needs.items()}
        result[component.name] = resolve(description, needs, found.how)
        text = _line(found, outputs, f"none of {', '.join(inputs)}" if rest else "no input")
        if text:
            trials.note(f"no dependencies are declared; {text}", component)
    return result, trials.lines()


def _looped(
    descriptions: Mapping[str, Description],
    wiring: Wiring,
    unknown: Mapping[str, frozenset[str]],
) -> dict[str, tuple[tuple[str, ...], tuple[str, ...]]]:
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
    return {name: (tuple(sorted(a)), tuple(sorted(b))) for name, (a, b) in found.items()}


def _line(found: Dependencies, outputs: Sequence[str], none: str) -> str:
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


def _probe(
    new: Instances,
    description: Description,
    outputs: Sequence[str],
    inputs: Sequence[str],
    others: Sequence[str],
    driven: Sequence[str],
) -> Dependencies:
    """The result for `outputs` in loops by `inputs` there, and for those that are a step late.

    `others` are the other outputs, `driven` all connected inputs.
    """
    if description.once_per_process:
        failure = "its FMU allows one instance only, so that it is not probed"
        return Dependencies({}, {}, failure if outputs else "")
    try:
        late = _late(new, (*outputs, *others), driven)
        needs = _moved_inputs(new, outputs, inputs) if outputs else {}
    except RunError as error:
        return Dependencies({}, {}, f"probing it failed: {error.message}" if outputs else "")
    late -= {name for name, found in needs.items() if found}
    how = dict.fromkeys(outputs, PROBED) | dict.fromkeys(sorted(late), STEPPED)
    return Dependencies(needs, how)


def _moved_inputs(
    new: Instances, outputs: Sequence[str], inputs: Sequence[str]
) -> dict[str, frozenset[str]]:
    """The inputs that each output follows."""
    needs: dict[str, set[str]] = {name: set() for name in outputs}
    moves = list(product(range(len(inputs)), SHARES))
    with new.instance() as instance:
        subject = Subject(instance, outputs, inputs)
        values, last, fresh = subject.start, list[Value](), list[Value]()
        for point in range(POINTS):
            sign = -1.0 if point % 2 else 1.0
            alone = [[sign * share * (k == n) for k in range(len(inputs))] for n, share in moves]
            others = [subject.moved(shares, values) for shares in alone]
            before_all = subject.at(values)
            seen = [(before_all, subject.at(other), subject.at(values)) for other in others]
            for output, before, then, now in zip(outputs, last, fresh, seen[0][0], strict=False):
                if not _differ(before, then) and _differ(then, now):
                    needs[output].update(inputs)  # setting brings what the step has not shown
            for (column, _), rows in zip(moves, seen, strict=True):
                for output, still, there, back in zip(outputs, *rows, strict=True):
                    if _differ(still, there) or _differ(still, back):
                        needs[output].add(inputs[column])
            if point + 1 < POINTS:
                values, last = subject.moved_together(sign), seen[-1][2]
                subject.set(values)
                subject.step(new.step)
                fresh = subject.read()
    return {name: frozenset(found) for name, found in needs.items()}


def _differ(a: Value, b: Value) -> bool:
    return a != b and not (a != a and b != b)  # two that are nan are the same


def _late(new: Instances, outputs: Sequence[str], inputs: Sequence[str]) -> set[str]:
    """Outputs that follow some input in the step after it is moved, and in no other.

    Nor before the next step, when it is back: what follows it at once is not late.
    """

    def course(share: float) -> tuple[list[Value], ...]:
        """Outputs after a step with the inputs moved, with the inputs back, and a step later."""
        with new.instance() as instance:
            subject = Subject(instance, outputs, inputs)
            shifted = subject.moved([share] * len(inputs))
            (first,) = subject.trajectory(new.short_step, 1, shifted)
            still = subject.at(subject.start)
            (second,) = subject.trajectory(new.short_step, 1)
            return first, still, second

    found = set()
    for name, *values in zip(outputs, *course(SHARES[0]), *course(0.0), strict=True):
        first, still, second = (
            abs(a - b) if isinstance(a, float) and isinstance(b, float) else float(a != b)
            for a, b in zip(values[:3], values[3:], strict=True)
        )
        lost = (1.0 - LOST_AGAIN) * first
        if second < lost <= still:
            found.add(name)
    return found
