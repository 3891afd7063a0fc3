"""`Prepared`: a system that can run, with the timing of its links and its overview as text.

Here is also which variables its results record: by default the outputs without large arrays, else
those that patterns choose.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from math import ceil

import networkx as nx

from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.cosim.system.component_steps import ComponentSteps
from m4e_fmi.cosim.system.simulation import ComponentStep, Simulation
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Link, Port, Wiring
from m4e_fmi.cosim.wiring.missing import is_idle_load, start_text, unfed
from m4e_fmi.cosim.wiring.structure import Structure
from m4e_fmi.coupling_algorithms import LinkDelay, algorithm_descriptor
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.type_rules import TYPES
from m4e_fmi.fmu.importer.worker import Host
from m4e_fmi.shown import listing

LARGEST_ARRAY = 9
"""Elements of an array that is recorded if nobody chooses: a vector, or a matrix of three by three.

Scalar variables of FMI 1.0 and 2.0 that are called y[1], y[2], … are an array.
"""
LARGE = 1e9
"""Bytes of results above which their size is noted before the run."""


def chosen(
    descriptions: Mapping[str, Description],
    patterns: Sequence[str],
    connected: Iterable[Port] = (),
) -> dict[str, list[Variable]]:
    """The variables to be recorded, by component, of all types but Binary.

    Without patterns these are all outputs but arrays of more than `LARGEST_ARRAY` elements of which
    none is `connected`. A pattern is ``component.variable``, where ``*`` stands for anything. With
    ``*`` it chooses among the outputs, elements of arrays included; without, it may name any
    variable, or an array. InputError for patterns that match nothing.
    """
    if not patterns:
        arrays = {(port.component, _array_of(port.variable)) for port in connected}
        result = {}
        for name, description in descriptions.items():
            outputs = _outputs(description)
            sizes = Counter(_array_of(v.name) for v in outputs)
            result[name] = [
                v
                for v in outputs
                if sizes[of := _array_of(v.name)] <= LARGEST_ARRAY or (name, of) in arrays
            ]
        return result
    found: dict[str, dict[str, Variable]] = {name: {} for name in descriptions}
    problems = []
    for pattern in patterns:
        matches = _chosen_by(descriptions, pattern)
        for component, variable in matches:
            found[component][variable.name] = variable
        if not matches:
            known = [f"{c}.{v.name}" for c, d in descriptions.items() for v in _outputs(d)]
            problems.append(
                Problem(f"no output is called {pattern!r}", suggestion(pattern, known, "outputs"))
            )
    InputError.raise_for(problems)
    return {name: list(members.values()) for name, members in found.items()}


def _array_of(name: str) -> str:
    """The name of the array of an element; of a scalar, its own name."""
    return name.rpartition("[")[0] if name.endswith("]") else name


def _outputs(description: Description) -> list[Variable]:
    return [v for v in description.of_causality("output") if v.type in TYPES]


def _chosen_by(descriptions: Mapping[str, Description], pattern: str) -> list[tuple[str, Variable]]:
    exact, _, name = pattern.partition(".")
    if exact in descriptions:
        variables = descriptions[exact].variables
        named = [variables[name]] if name in variables else []
        named = named or [v for v in variables.values() if v.name.endswith("]")]
        found = [(exact, v) for v in named if name in (v.name, _array_of(v.name))]
        if found:
            return [(c, v) for c, v in found if v.type in TYPES]
    # brackets are part of names
    expression = re.compile(".*".join(map(re.escape, pattern.split("*"))))
    return [
        (component, v)
        for component, description in descriptions.items()
        for v in _outputs(description)
        if expression.fullmatch(f"{component}.{v.name}")
    ]


def volume(simulation: Simulation, values: int) -> tuple[float, str]:
    """The size [bytes] of results with so many values in each row, the time included; in words.

    It is a lower bound if the steps are adaptive.
    """
    interval = simulation.output_interval
    span = simulation.stop_time - simulation.start_time
    rows = ceil(span / (interval or simulation.step_size)) + 1
    size = 8.0 * rows * values
    least = "at least " if interval is None and simulation.coupling_tolerance is not None else ""
    text = f"results: {least}{rows:,} rows of {values:,} values, {size_text(size)}"
    if size > LARGE:
        text += "; a longer output_interval, or fewer --variables, make them smaller"
    return size, text


def size_text(size: float) -> str:
    """A number of bytes with its unit, as ``"1.5 GB"``."""
    for unit in ("B", "kB", "MB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:,.1f} GB"


class Timing(Enum):
    """How an input follows its source during a step; the values are texts for a person."""

    KNOWN = "in time: its source has already made the step"
    SOLVED = "in time: solved together with its source"
    CORRECTED = "in time: corrected by a second pass"
    PREDICTED = "predicted from derivatives that its FMU declares"
    EXTRAPOLATED = "extrapolated from the step before"
    LATE = "one step late: held at its value at the start of the step"
    TAKEN = "sampled at the points of a component that steps less often"
    DELAYED = "one step late, as its connection says: held at its source's previous value"
    HELD = "held between the points of a component that steps less often"
    SWITCHED = "held during each step: a change acts from the end of its step"


@dataclass(frozen=True)
class Prepared:
    """A system with its FMUs built, its connections resolved, its loops and component steps known.

    `system` has the step that meets the points of all components. `descriptions` are those of the
    FMUs by component, with probed dependencies; `rates` the steps of the components that have their
    own, `hosts` the conditions of those that run in processes of their own. `notes` say what
    preparation has changed or found, `warnings` what seems to be wrong: missing connections, FMUs
    whose saved states fail; one line each. `recorded` are the variables by component that results
    of a run have: none in a run without results.
    """

    system: System
    descriptions: dict[str, Description] = field(repr=False)
    wiring: Wiring = field(repr=False)
    structure: Structure = field(repr=False)
    rates: ComponentSteps = field(repr=False)
    hosts: Mapping[str, Host] = field(default_factory=dict, repr=False)
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    recorded: Mapping[str, Sequence[Variable]] = field(default_factory=dict, repr=False)

    def recording(self, patterns: Sequence[str] = ()) -> Prepared:
        """The same system, whose runs record what `patterns` choose: see `chosen`."""
        found = chosen(self.descriptions, patterns, self.wiring.sources)
        return replace(self, recorded=found)

    @property
    def columns(self) -> int:
        """The number of values in a row of the results, including the time."""
        return 1 + sum(map(len, self.recorded.values()))

    @property
    def longer(self) -> dict[str, ComponentStep]:
        """Steps that are longer than the system's, of components that are not sampled.

        A sampled component, as a digital controller, is known by its connected outputs (its
        outputs, if none is connected): all are discrete, so that its step is a part of what it is.
        All others are continuous systems, of which a longer step is an approximation.
        """
        return {
            name: rate
            for name, rate in self.rates.items()
            if rate.is_longer
            and any(v.variability == "continuous" for v in self._given(name) if v.type == "Real")
        }

    @property
    def halved(self) -> dict[str, ComponentStep]:
        """Those `longer` steps at half their length, where the FMUs make such steps."""
        return {
            name: replace(rate, step=rate.step / 2)
            for name, rate in self.longer.items()
            if not rate.constant and self.descriptions[name].internal_step is None
        }

    def _given(self, component: str) -> list[Variable]:
        """The connected outputs of a component, or all if none is connected."""
        outputs = self.descriptions[component].of_causality("output")
        connected = {p.variable for p in self.wiring.sources if p.component == component}
        return [v for v in outputs if v.name in connected] or outputs

    @property
    def timings(self) -> dict[Link, Timing]:
        """The timing of every link at communication points, under the system's algorithm.

        During a step an algorithm knows some outputs only as they were at its start, and others
        over the whole step.
        """
        descriptions, wiring, rates = self.descriptions, self.wiring, self.rates

        def skips(component: str) -> bool:
            return component in rates and rates[component].is_longer

        followed = [
            link
            for link in wiring.links
            if link.is_real
            and not (link.delayed or skips(link.source.component) or skips(link.target.component))
        ]
        cycles = component_cycles(descriptions, followed)
        cycle_of = {name: cycle for cycle in cycles for name in cycle}
        corrects = not self.structure.loops and all(
            any(descriptions[name].saves_state for name in cycle) for cycle in cycles
        )
        place = {name: k for k, name in enumerate(self.structure.execution_order)}
        delay = algorithm_descriptor(self.system.simulation.algorithm).link_delay

        def in_order(link: Link) -> Timing:
            source, target = link.source, link.target
            if place[source.component] < place[target.component]:
                return Timing.KNOWN
            if source.variable in descriptions[source.component].output_derivatives:
                return Timing.PREDICTED
            return Timing.EXTRAPOLATED

        def timing(link: Link) -> Timing:
            if link.delayed:
                return Timing.DELAYED
            if skips(link.target.component):
                return Timing.TAKEN
            if skips(link.source.component):
                return Timing.HELD
            if not link.is_real:
                return Timing.SWITCHED
            if delay is LinkDelay.ONE_STEP:
                return Timing.LATE
            if delay is LinkDelay.SOLVED:
                return Timing.SOLVED
            if delay is LinkDelay.EXECUTION_ORDER or not corrects:
                return in_order(link)
            if link.target.component not in cycle_of.get(link.source.component, ()):
                return Timing.KNOWN
            returns = descriptions[link.target.component].saves_state
            return Timing.CORRECTED if returns else in_order(link)

        return {link: timing(link) for link in wiring.links}

    def __str__(self) -> str:
        """Components, connections, loops and unconnected inputs as text."""
        system, wiring, structure = self.system, self.wiring, self.structure
        lines = [f"system {system.name}", "components, in the order they step:"]
        lines += [f"  {name}  {self.descriptions[name].path}" for name in structure.execution_order]
        if self.rates:
            lines.append("components with their own step size:")
            lines += [f"  {name}  {own}" for name, own in self.rates.items()]
        if self.hosts:
            lines.append(f"in processes of their own: {', '.join(self.hosts)}")
        lines += self.notes
        lines += [f"warning: {line}" for line in self.warnings]
        lines += ["connections:", *_connections(self)]
        cycles = component_cycles(self.descriptions, wiring.links)
        if cycles:
            lines.append("components that interact:")
            ordered = ([n for n in structure.execution_order if n in one] for one in cycles)
            lines += [f"  {', '.join(names)}" for names in ordered]
        if structure.loops:
            lines.append("algebraic loops, solved at every communication point:")
            lines += [f"  {' -> '.join(map(str, (*loop, loop[0])))}" for loop in structure.loops]
        lines.append("unconnected inputs, which keep their start values:")
        lines += _unconnected(self) or ["  none"]
        lines.append(_times(system))
        lines.append(volume(system.simulation, self.columns)[1])
        return "\n".join(lines)

    def __repr__(self) -> str:
        return listing(
            f"Prepared system {self.system.name!r}: {len(self.wiring.links)} connected variables",
            components=self.descriptions,
            connections=self.system.connections,
            notes=self.notes,
        )


def component_cycles(names: Iterable[str], links: Iterable[Link]) -> list[frozenset[str]]:
    """Sets of components that depend on one another in a cycle of connections."""
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(names)
    graph.add_edges_from((link.source.component, link.target.component) for link in links)
    return [
        frozenset(group)
        for group in nx.strongly_connected_components(graph)
        if len(group) > 1 or any(graph.has_edge(name, name) for name in group)
    ]


def outline(system: System, waiting: Collection[str]) -> str:
    """The system as its file has it, while the FMUs of the components `waiting` are not built."""
    lines = [f"system {system.name}", "components:"]
    for component in system.components:
        source = component.source
        told = source.name if isinstance(source, Kind) else source.path
        later = "  (not built yet)" if component.name in waiting else ""
        lines.append(f"  {component.name}  {told}{later}")
    lines += ["connections:", *(f"  {text}" for text in system.connections)]
    lines.append(_times(system))
    lines.append(
        f"building {', '.join(waiting)} takes long and is left to `m4e-fmi run`: variables, loops "
        "and what is connected to nothing are shown when that is done"
    )
    return "\n".join(lines)


def _times(system: System) -> str:
    simulation = system.simulation
    times = f"{simulation.start_time:g} s to {simulation.stop_time:g} s"
    return f"{times}, step {simulation.step_size:g} s, {simulation.algorithm}"


def _connections(prepared: Prepared) -> list[str]:
    """Each connection with what it carries, and under it how its inputs follow their sources."""
    timings = prepared.timings
    lines = []
    for index, text in enumerate(prepared.system.connections):
        own = [link for link in prepared.wiring.links if link.connection == index]
        once = [link for link in prepared.wiring.initial_links if link.connection == index]
        count = len(own) + len(once)
        kinds = dict.fromkeys(link.kind for link in (*own, *once) if not link.is_real)
        told = ", ".join([f"{count} variable{'s' * (count != 1)}", *kinds])
        lines.append(f"  {text}  ({told})")
        for timing in Timing:
            late = [link for link in own if timings[link] is timing]
            if late:
                lines.append(f"      {_named(late, len(own))}{timing.value}")
        if once:
            lines.append(f"      {_named(once, count)}transferred once, at initialisation")
        converted = [
            f"{k.target} = {k.factor:g} * {k.source}"
            + (f" {'+-'[k.offset < 0]} {abs(k.offset):g}" if k.offset else "")
            for k in (*own, *once)
            if not k.is_plain
        ]
        if converted:
            lines.append(f"      converted: {', '.join(converted)}")
    return lines


def _unconnected(prepared: Prepared) -> list[str]:
    """Unconnected inputs with their start values; loads of bodies that are 0, by their number."""
    lines, idle = [], Counter[str]()
    given = {c.name: c.start for c in prepared.system.components}
    free = set(unfed(prepared.system, prepared.wiring))
    for port in prepared.wiring.unconnected:
        if port in free and is_idle_load(port, prepared.descriptions):
            idle[port.component] += 1
            continue
        own = start_text(prepared.descriptions[port.component].variables[port.variable])
        lines.append(f"  {port} = {given[port.component].get(port.variable, own)}")
    return lines + [
        f"  {component}: {count} force{'s' * (count > 1)}, moments or efforts on its bodies, which "
        "are 0"
        for component, count in idle.items()
    ]


def _named(links: list[Link], count: int) -> str:
    """The links by their sources, if they are not all there are."""
    if len(links) == count:
        return ""
    return ", ".join(str(link.source) for link in links) + ": "
