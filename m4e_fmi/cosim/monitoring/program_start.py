"""The checks of a run's start for a composed program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from m4e_fmi.cosim.system.component import answers
from m4e_fmi.cosim.system.connection_text import parse_connection
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.fmu import Description
from m4e_fmi.fmu.export.description import expected_description
from m4e_fmi.program import TIME, LocalLaw, Part, Program, evaluated, tangent


def program_start_warnings(system: System, program: Program) -> tuple[str, ...]:
    """Warnings of the kinds of a composed program at its start, one line each.

    `program` is that of `system`. They are those of a coupled run of its parts. A body whose
    connections lead through a bus is not looked at if a component is left open.
    """
    names = {part.name for part in program.parts}
    is_whole = all(c.name in names for c in system.components)
    known = names.union(system.buses) if is_whole else names
    laws = {part.name for part in program.parts if isinstance(part.origin, LocalLaw)}
    components = [c for c in system.components if c.name in names]
    rest = replace(
        system,  # start values of laws are in their FMUs
        components=tuple(replace(c, start={}) if c.name in laws else c for c in components),
        connections=tuple(text for text in system.connections if _ends(text) <= known),
        inputs={},
        outputs={},
    )
    start = ProgramStart(program)
    descriptions = {name: one.description for name, one in start.instances.items()}
    given = rest, descriptions, connect(rest, descriptions), start
    return tuple(answers(rest.components, descriptions, lambda k: k.doubts_at_start, *given))


def _ends(text: str) -> set[str]:
    """The components or buses at both ends of a connection."""
    written = parse_connection(text)
    return {name.partition(".")[0] for name in (written.left, written.right)}


class ProgramStart:
    """A composed program at its start values, read like a network at the start of a run."""

    def __init__(self, program: Program) -> None:
        self._program = program
        groups = (program.parameters, program.inputs, program.states)
        self._start = {v.name: v.start for group in groups for v in group} | {TIME: 0.0}
        self.instances = {part.name: self._started(part) for part in program.parts}

    def _started(self, part: Part) -> PartStart:
        found = evaluated(self._program.tape, list(part.nodes.values()), self._start)
        given = {name: found[node] for name, node in part.nodes.items()} | {TIME: 0.0}
        description = expected_description(part.program, Path(f"{part.name}.fmu"))
        if isinstance(part.origin, LocalLaw):
            # of units of 1, which stand for those that the FMU of a law lacks, nothing is known
            bare = {
                name: replace(v, unit="", dimension=None)
                for name, v in description.variables.items()
                if v.unit == "1"
            }
            description = replace(description, variables={**description.variables, **bare})
        return PartStart(part, replace(description, directional_derivatives=True), given)

    def read(self, name: str) -> float:
        """The value of ``component.variable``, in its unit; KeyError for an unknown variable."""
        component, _, variable = name.partition(".")
        return self.instances[component].value(variable)


@dataclass
class PartStart:
    """One part at the start; `given` are its parameters, inputs and states by name.

    `description` is that of its FMU, which is not built.
    """

    part: Part
    description: Description
    given: Mapping[str, float]
    _slopes: dict[str, dict[str, float]] = field(default_factory=dict)

    def value(self, variable: str) -> float:
        """The value of a variable, in its unit; KeyError for an unknown variable."""
        return self.given[variable] if variable in self.given else self._results[variable]

    @cached_property
    def _results(self) -> dict[str, float]:
        program = self.part.program
        nodes = {v.name: k for v, k in zip(program.outputs, program.results, strict=True)}
        nodes |= {v.name: k for v, k in zip(program.calculated, program.constants, strict=True)}
        found = evaluated(program.tape, list(nodes.values()), self.given)
        return {name: found[k] for name, k in nodes.items()}

    def directional_derivative(self, output: str, known: str) -> float:
        """∂output/∂known of an output and an input, in their units."""
        if known not in self._slopes:
            self._slopes[known] = self._slopes_by(known)
        return self._slopes[known][output]

    def _slopes_by(self, known: str) -> dict[str, float]:
        """Derivatives of all outputs by one input."""
        program = self.part.program
        change = tangent(program, [known])
        found = evaluated(change.tape, change.results, {**self.given, f"d({known})": 1.0})
        slopes = [found[k] for k in change.results[len(program.states) :]]
        return {v.name: slope for v, slope in zip(program.outputs, slopes, strict=True)}
