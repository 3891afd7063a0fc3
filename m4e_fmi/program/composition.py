"""Several connected programs as one, and a program whose inputs follow a law.

The parts are recorded anew, one after another, on one tape: an input that is connected becomes the
expression that its source computes, in the order in which sources need inputs. Algebraic loops are
solved if they are linear (`loops`). All names get the name of their part in front.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from m4e_fmi.errors import Named, UnknownNameError
from m4e_fmi.program.loops import LoopError, solved_loop
from m4e_fmi.program.program import TIME, Loop, Part, Program, Recorder, Solution, Variable
from m4e_fmi.program.tape import Scalar, Tape, TapeCopy

if TYPE_CHECKING:
    import networkx as nx

Place = tuple[str, str]
"""Name of a part, and of a variable in it."""
Graph: TypeAlias = "nx.DiGraph[Place]"
"""Connected inputs and parameters, with an edge to each that needs another."""
Law = Callable[[Mapping[str, Scalar]], Scalar | float]
"""The value of an input as a function of states, parameters, other inputs and `time` by name."""


@dataclass(frozen=True)
class Connection:
    """The input or parameter `target` is `factor` · the value of `source` + `offset`.

    What several connections lead to one target adds up.
    A source is an output, a state, the rate ``der(state)`` of one, or a calculated parameter.
    """

    source: Place
    target: Place
    factor: float = 1.0
    offset: float = 0.0


class AlgebraicLoopError(ValueError):
    """An algebraic loop that is not solved: `cycle` are inputs along it, `reason` says why not.

    One that `is_singular` has no single solution at the start values.
    """

    def __init__(self, cycle: Sequence[Place], reason: str, *, is_singular: bool = False) -> None:
        self.cycle, self.reason, self.is_singular = tuple(cycle), reason, is_singular
        names = " -> ".join(".".join(place) for place in (*cycle, cycle[0]))
        super().__init__(f"algebraic loop {names}: {reason}")


def compose(
    name: str,
    parts: Mapping[str, Program],
    connections: Iterable[Connection],
    *,
    description: str = "",
    inputs: Mapping[str, Sequence[Place]] | None = None,
    outputs: Mapping[str, Place] | None = None,
    origins: Mapping[str, object] | None = None,
) -> Program:
    """The program of all `parts`, connected; its variables are called ``part.variable``.

    Inputs without a connection stay inputs; parameters stay parameters, and those that a connection
    leads to become what it carries. `inputs` are inputs of the whole, with a name of their own, and
    the inputs of the parts that take their value, which have the same unit; `outputs` are further
    names of outputs. `origins` are what parts were recorded from, kept in `Program.parts`.

    UnknownNameError for a place that is not there, AlgebraicLoopError for a loop that is not linear
    or singular at the start values.
    """
    composer = _Composer(name, description, parts, list(connections), inputs or {})
    composer.connect()
    return composer.program(outputs or {}, origins or {})


class _Composer:
    """A composition under way; `values` has the scalar of each place that is known."""

    def __init__(
        self,
        name: str,
        description: str,
        parts: Mapping[str, Program],
        connections: Sequence[Connection],
        inputs: Mapping[str, Sequence[Place]],
    ) -> None:
        self.parts = parts
        self.recorder = Recorder(name, description)
        self.nodes = {part: _value_nodes(program) for part, program in parts.items()}
        self.into: dict[Place, list[Connection]] = {}
        for connection in connections:
            self.into.setdefault(connection.target, []).append(connection)
        self._check(connections)
        self.scalars: dict[Place, Scalar] = {}
        self.loops: list[Loop] = []
        self._declare(inputs)
        time = {TIME: self.recorder.time}
        self.copies = {
            part: TapeCopy(program.tape, self.recorder.tape, time)
            for part, program in parts.items()
        }
        for (part, variable), scalar in self.scalars.items():
            self.copies[part].give(variable, scalar)

    def _check(self, connections: Sequence[Connection]) -> None:
        """UnknownNameError with all ends that are not there."""
        for what, ends, known in (
            (
                "output, state or calculated parameter",
                [c.source for c in connections],
                {f"{part}.{name}" for part, names in self.nodes.items() for name in names},
            ),
            (
                "input or parameter",
                [c.target for c in connections],
                {
                    f"{part}.{v.name}"
                    for part, program in self.parts.items()
                    for v in (*program.inputs, *program.parameters)
                },
            ),
        ):
            unknown = [".".join(end) for end in ends if ".".join(end) not in known]
            if unknown:
                raise UnknownNameError.of(f"there is no {what}", unknown, known)

    def _declare(self, inputs: Mapping[str, Sequence[Place]]) -> None:
        """Declare parameters, inputs and states: all that no connection gives."""
        shared = {place: name for name, places in inputs.items() for place in places}
        groups = ("parameters", "inputs", "states")
        own = [
            (group, (part, v.name), v)
            for group in groups
            for part, program in self.parts.items()
            for v in getattr(program, group)
            if (part, v.name) not in self.into
        ]
        names = {place: shared.get(place, ".".join(place)) for _, place, _ in own}
        declare = {
            "parameters": self.recorder.parameter,
            "inputs": self.recorder.input,
            "states": self.recorder.state,
        }
        known: dict[str, Scalar] = {}
        for group, place, v in own:
            name, of = names[place], (place[0], v.derivative_of or "")
            if name not in known:
                variable = replace(v, name=name, derivative_of=names.get(of))
                known[name] = declare[group](variable)
            self.scalars[place] = known[name]

    def connect(self) -> None:
        """Let each target stand for what its source computes, loops solved."""
        import networkx as nx

        needs = {
            target: [
                place
                for c in several
                for name in self.parts[c.source[0]].dependencies(self._node(c.source))
                if (place := (c.source[0], name)) in self.into
            ]
            for target, several in self.into.items()
        }
        graph: Graph = nx.DiGraph()
        graph.add_nodes_from(self.into)
        graph.add_edges_from((k, target) for target, places in needs.items() for k in places)
        for members in _in_order(graph):
            if len(members) == 1 and not graph.has_edge(members[0], members[0]):
                self._give(members[0], self._value(members[0], self.copies))
            else:
                self._solve(graph.subgraph(members), members)

    def _node(self, source: Place) -> int:
        return self.nodes[source[0]][source[1]]

    def _give(self, target: Place, scalar: Scalar) -> None:
        self.scalars[target] = scalar
        self.copies[target[0]].give(target[1], scalar)

    def _value(self, target: Place, copies: Mapping[str, TapeCopy]) -> Scalar:
        """The sum of what the connections into `target` carry."""
        terms: list[Scalar] = []
        for c in self.into[target]:
            value = copies[c.source[0]](self._node(c.source))
            value = value if c.factor == 1.0 else c.factor * value
            terms.append(value if c.offset == 0.0 else value + c.offset)
        return sum(terms[1:], terms[0])

    def _solve(self, loop: Graph, members: Sequence[Place]) -> None:
        """Solve a loop for the inputs that cut it, then give all of its members."""
        import networkx as nx

        cuts = _cuts(loop, members)
        rest = loop.subgraph([place for place in members if place not in cuts])
        order = list(nx.lexicographical_topological_sort(rest, key=members.index))
        tape = self.recorder.tape
        unknowns = [tape.symbol(f"unknown {'.'.join(place)}") for place in cuts]
        zeros = [tape.constant(0.0)] * len(cuts)
        values, constants = (self._around(cuts, order, given) for given in (unknowns, zeros))
        start = {v.name: v.start for v in self.recorder.variables("parameters", "inputs", "states")}
        try:
            solved, shares = solved_loop(unknowns, values, constants, {**start, TIME: 0.0})
        except LoopError as error:
            edges: list[tuple[Place, Place]] = list(nx.find_cycle(loop))
            cycle = [place for place, _ in edges]
            singular = error.is_singular
            raise AlgebraicLoopError(cycle, error.reason, is_singular=singular) from None
        for place, scalar in zip(cuts, solved, strict=True):
            self._give(place, scalar)
        names = tuple(".".join(place) for place in cuts)
        self.loops.append(Loop(names, tuple(share.index for share in shares)))
        for place in order:
            self._give(place, self._value(place, self.copies))

    def _around(
        self, cuts: Sequence[Place], order: Sequence[Place], given: Sequence[Scalar]
    ) -> list[Scalar]:
        """The values that come back to the cuts of a loop if they are `given`."""
        copies = dict(self.copies)
        for part in {part for part, _ in (*cuts, *order)}:
            copies[part] = copies[part].fork()
        for (part, name), scalar in zip(cuts, given, strict=True):
            copies[part].give(name, scalar)
        for place in order:
            copies[place[0]].give(place[1], self._value(place, copies))
        return [self._value(place, copies) for place in cuts]

    def program(self, outputs: Mapping[str, Place], origins: Mapping[str, object]) -> Program:
        """The finished program."""
        r = self.recorder
        fixed = {v.name for v in r.variables("parameters")}
        for part, program in self.parts.items():
            copy = self.copies[part]
            for v, rate in zip(program.states, program.rates, strict=True):
                r.rate(f"{part}.{v.name}", copy(rate))
        calculated: list[tuple[Variable, Scalar]] = []
        for part, program in self.parts.items():
            copy = self.copies[part]
            for v, node in zip(program.outputs, program.results, strict=True):
                r.output(self._named(part, v), copy(node))
            for v, node in zip(program.calculated, program.constants, strict=True):
                calculated.append((self._named(part, v), copy(node)))
        symbols = r.tape.symbols_of_each(scalar.index for _, scalar in calculated)
        for v, scalar in calculated:
            if symbols[scalar.index] <= fixed:
                r.calculate(v, scalar)
            else:  # of a parameter that a connection makes vary
                r.output(v, scalar)
        for name, (part, source) in outputs.items():
            of = self.parts[part]
            sources = (*of.states, *of.outputs, *of.calculated)
            v = next(v for v in sources if v.name == source)
            variable = replace(v, name=name, derivative_of=None, local=False)
            r.output(variable, self.copies[part](self._node((part, source))))
        solutions: list[Solution] = []
        parts, loops = list[Part](), [*self.loops]
        for part, program in self.parts.items():
            copy = self.copies[part]
            solutions += [_MovedSolution(one, program.tape, copy) for one in program.solutions]
            known = (*program.parameters, *program.inputs, *program.states)
            given = {v.name: self.scalars[part, v.name].index for v in known}
            parts.append(Part(part, program, given, origins.get(part)))
            for loop in program.loops:
                names = tuple(f"{part}.{name}" for name in loop.inputs)
                loops.append(Loop(names, tuple(copy(node).index for node in loop.shares)))
        whole = r.program(solutions=tuple(solutions))
        return replace(whole, parts=tuple(parts), loops=tuple(loops))

    def _named(self, part: str, v: Variable) -> Variable:
        of = v.derivative_of
        known = of is not None and (part, of) not in self.into
        return replace(v, name=f"{part}.{v.name}", derivative_of=f"{part}.{of}" if known else None)


def _value_nodes(program: Program) -> dict[str, int]:
    """The node of each source of connections: states, their rates as ``der(state)``, outputs,
    calculated parameters."""
    tape = program.tape
    found = {v.name: tape.node(("symbol", v.name)) for v in program.states}
    rates = zip(program.states, program.rates, strict=True)
    found |= {f"der({v.name})": node for v, node in rates}
    found |= {v.name: k for v, k in zip(program.outputs, program.results, strict=True)}
    return found | {v.name: k for v, k in zip(program.calculated, program.constants, strict=True)}


def _in_order(graph: Graph) -> list[list[Place]]:
    """Strongly connected places, each group after those it needs; in the order of the graph."""
    import networkx as nx

    number = {place: k for k, place in enumerate(graph)}
    condensed = nx.condensation(graph)
    members = {
        group: sorted(condensed.nodes[group]["members"], key=number.__getitem__)
        for group in condensed
    }
    order = nx.lexicographical_topological_sort(condensed, key=lambda g: number[members[g][0]])
    return [members[group] for group in order]


def _cuts(loop: Graph, members: Sequence[Place]) -> list[Place]:
    """A few places that cut the loop when removed: those with most neighbours first."""
    import networkx as nx

    cuts: list[Place] = []
    graph: Graph = nx.DiGraph(loop)
    while True:
        looped = [
            place
            for group in nx.strongly_connected_components(graph)
            for place in group
            if len(group) > 1 or graph.has_edge(place, place)
        ]
        if not looped:
            return cuts
        looped.sort(key=members.index)
        inner = graph.subgraph(looped)
        cut = max(looped, key=lambda place: inner.in_degree(place) * inner.out_degree(place))
        cuts.append(cut)
        graph.remove_node(cut)


class _MovedSolution:
    """A solution on the tape that `copy` copies to; `solution` is the original on `tape`.

    The response to a drive is recorded once on the original tape, for symbols, and copied for each
    drive: what has no effect folds away.
    """

    def __init__(self, solution: Solution, tape: Tape, copy: TapeCopy) -> None:
        self._solution, self._tape, self._copy = solution, tape, copy

    @property
    def unknowns(self) -> Sequence[Scalar]:
        """The scalars that are solved for."""
        return [self._copy(s.index) for s in self._solution.unknowns]

    def balance(self) -> Sequence[Scalar]:
        """Scalars that the unknowns depend on."""
        return [self._copy(s.index) for s in self._balance]

    @cached_property
    def _balance(self) -> Sequence[Scalar]:
        return self._solution.balance()

    @cached_property
    def _response(self) -> Sequence[Scalar | int]:
        """The response to a change of all of the balance, on the original tape."""
        changes = {k: self._tape.symbol(_change(k)) for k in range(len(self._balance))}
        return self._solution.response(self._solution.drive(changes))

    def drive(self, change: Mapping[int, Scalar]) -> Mapping[int, Scalar]:
        """The change itself: it becomes a drive in `response`."""
        return change

    def response(self, drive: Mapping[int, Scalar]) -> Sequence[Scalar | int]:
        """Change of the unknowns for a `drive`."""
        copy, zero = self._copy.fork(), self._copy.target.constant(0.0)
        for k in range(len(self._balance)):
            copy.give(_change(k), drive.get(k, zero))
        return [copy(s.index) if isinstance(s, Scalar) else s for s in self._response]


def _change(place: int) -> str:
    return f"change of balance {place}"


def with_feedback(program: Program, laws: Mapping[str, Law]) -> Program:
    """`program` with the inputs named by `laws` replaced by what these record.

    Such an input becomes an output of the same name. UnknownNameError for an input that is not
    there, or if a law asks for a name that is not.

    >>> brake = with_feedback(program, {"joint.wheel.effort": lambda x: -2.0 * x["joint.wheel.u"]})
    """
    known = {v.name for v in program.inputs}
    unknown = sorted(set(laws) - known)
    if unknown:
        raise UnknownNameError.of(f"{program.name} has no input", unknown, known)
    recorder = Recorder(program.name, program.description)
    scalars = {TIME: recorder.time}
    scalars |= {v.name: recorder.parameter(v) for v in program.parameters}
    scalars |= {v.name: recorder.input(v) for v in program.inputs if v.name not in laws}
    scalars |= {v.name: recorder.state(v) for v in program.states}
    readable = Named("no law can depend on", scalars)
    given: dict[str, Scalar] = {}
    for name, law in laws.items():
        value = law(readable)
        given[name] = value if isinstance(value, Scalar) else recorder.tape.constant(value)
    copy = TapeCopy(program.tape, recorder.tape, {**scalars, **given})
    for v, rate in zip(program.states, program.rates, strict=True):
        recorder.rate(v.name, copy(rate))
    for v, result in zip(program.outputs, program.results, strict=True):
        recorder.output(v, copy(result))
    for v, constant in zip(program.calculated, program.constants, strict=True):
        recorder.calculate(v, copy(constant))
    for v in program.inputs:
        if v.name in laws:
            recorder.output(v, given[v.name])
    return recorder.program()
