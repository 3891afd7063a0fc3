"""The program of a system: those of its components, connected as its connections say."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from m4e_fmi.analysis.attitudes import attitudes
from m4e_fmi.analysis.equilibrium import equilibrium
from m4e_fmi.analysis.points import local_parts, operating_point
from m4e_fmi.analysis.response import InWaves, WaveForces
from m4e_fmi.cosim.composition.parts import ComponentSelection, Made, look_at, stand_ins
from m4e_fmi.cosim.composition.static_law import StaticLaw
from m4e_fmi.cosim.preparation.components import Tell, silent
from m4e_fmi.cosim.system.component import Component, Kind, kind_of
from m4e_fmi.cosim.system.start_values import start_values
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.cosim.wiring.links import Link, Wiring
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.fmu import Description
from m4e_fmi.joints import ATTITUDE
from m4e_fmi.program import AlgebraicLoopError, Connection, Program, compose
from m4e_fmi.program.composition import Place

ORIGIN = "equilibrium"
"""Who gives the start values, in messages and results."""


def system_program(
    system: System,
    *,
    keep_open: Collection[str] = (),
    settled: Collection[str] = (),
    build_directory: str | Path = "build",
    tell: Tell | None = None,
) -> Program:
    """The equations of all components as one program, with variables ``component.variable``.

    Connected inputs and parameters become what their connections carry; others stay. Components
    named in `keep_open` are left out: what they take are outputs, what they give are inputs. Those
    that are no equations (FMUs, Python code such as MoorDyn) must be named, there or in `settled`:
    those take part by their static law, y0 + K (u − u0) about a point. Their FMUs, which are built
    in `build_directory`, are brought to rest there with held inputs; `equilibrium` and `linearize`
    do that again where they come to, others have the law about the start values. Start values are
    the system's. The components' own steps, the algorithm and the scenario do not take part.
    An own input of the system has one unit and start value: those of its members must agree.

    `tell` gets lines of progress, and one for each component that is left open or settled.
    InputError with all problems of the system; with components that are no equations, connections
    that are delayed, and loops that have no solution as linear ones. RunError where a component
    does not settle.
    """
    named = ComponentSelection(frozenset(keep_open), frozenset(settled))
    return _program(system, named, build_directory=build_directory, tell=tell or silent)


def system_in_waves(
    system: System,
    *,
    highest: float,
    keep_open: Collection[str] = (),
    settled: Collection[str] = (),
    build_directory: str | Path = "build",
    tell: Tell | None = None,
) -> InWaves:
    """As `system_program`, with the forces of waves as inputs, up to `highest` [rad/s] at least.

    InputError as there, and where no component has a `response` (`FmuKind`).
    """
    named = ComponentSelection(frozenset(keep_open), frozenset(settled))
    forces: dict[str, WaveForces] = {}

    def drawn(component: Component, tell: Tell) -> Made | None:
        source = component.source
        if not isinstance(source, Kind):
            return None
        found = kind_of(source.name).response(
            source.config, name=component.name, folder=system.folder, highest=highest,
            progress=tell,
        )  # fmt: skip
        if found is None:
            return None
        made, forces[component.name] = found
        return made

    program = _program(
        system, named, build_directory=build_directory, tell=tell or silent, drawn=drawn
    )
    forces = {name: f for name, f in forces.items() if name not in named.open}
    if not forces:
        message = f"{system.name}: no component gives forces of waves"
        raise InputError.single(message, "a response needs a component whose forces come from them")
    return InWaves(program, forces)


def _program(
    system: System,
    named: ComponentSelection,
    *,
    build_directory: str | Path,
    tell: Tell,
    drawn: Callable[[Component, Tell], Made | None] | None = None,
) -> Program:
    """The program of a system, of components that are no FMU as `drawn`; see `system_program`."""
    found = look_at(system, named, tell, drawn)
    wiring = connect(system, found.descriptions)
    for name in sorted(named.open):
        lacking = [
            str(link.target)
            for link in wiring.all_links
            if link.source.component == name and link.target.component in found.programs
        ]
        tell(f"note: left open: {name}; inputs instead of it: {', '.join(lacking) or 'none'}")
    laws = stand_ins(
        system,
        found.settled,
        wiring,
        found.descriptions,
        build_directory=build_directory,
        tell=tell,
    )
    programs = {**found.programs, **{name: program for name, (program, _) in laws.items()}}
    inner = _inner_links(system, wiring, programs, laws, delays=named.at_rest)
    parts = dict(_started(system, programs, found.descriptions))
    own, given = _outer(system, programs)
    if problems := [p for name, ends in own.items() for p in _different(system, name, ends, parts)]:
        raise InputError(problems)
    links = [
        Connection(
            (link.source.component, link.source.variable),
            (link.target.component, link.target.variable),
            link.factor,
            link.offset,
        )
        for link in inner
    ]
    try:
        whole = compose(
            system.name,
            parts,
            links,
            description=system.description,
            inputs=own,
            outputs=given,
            origins={**found.origins, **{name: law for name, (_, law) in laws.items()}},
        )
    except AlgebraicLoopError as error:
        raise _of_loop(system, inner, error) from None
    if laws:
        whole = whole.with_start(dict(operating_point(whole).values))
    for name, (_, law) in laws.items():
        tell(f"note: settled: {name}: {law}")
    return whole


def _started(
    system: System, programs: Mapping[str, Program], descriptions: Mapping[str, Description]
) -> Iterator[tuple[str, Program]]:
    """The programs with those start values of the system whose variables they have."""
    given = {c.name: c for c in system.components}
    for name, program in programs.items():
        known = {v.name for v in (*program.parameters, *program.inputs, *program.states)}
        start = start_values(given[name], descriptions[name])
        values = {k: float(value) for k, value in start.items() if k in known}
        yield name, program.with_start(values)


def _inner_links(
    system: System,
    wiring: Wiring,
    programs: Mapping[str, Program],
    laws: Collection[str],
    *,
    delays: bool,
) -> list[Link]:
    """Links between two programs; InputError with the delayed ones unless `delays` are allowed.

    Delays have no effect on static laws, and outputs of laws that are not Real stay constant.
    """
    inner = [
        link
        for link in wiring.all_links
        if link.source.component in programs
        and link.target.component in programs
        and (link.is_real or link.source.component not in laws)
    ]
    delayed = dict.fromkeys(
        link.connection
        for link in inner
        if link.delayed
        and not delays
        and not {link.source.component, link.target.component}.intersection(laws)
    )
    if delayed:
        message = "this connection is delayed by a step: one program has no steps"
        remedy = "leave out the delay, or keep one of its components open"
        raise InputError([system.problem(("connections", k), message, remedy) for k in delayed])
    return inner


def _outer(
    system: System, programs: Mapping[str, Program]
) -> tuple[dict[str, list[Place]], dict[str, Place]]:
    """The system's own inputs that lead into programs, and its own outputs that programs give."""
    takes, gives = dict[str, Place](), dict[str, Place]()
    for part, p in programs.items():
        takes |= {f"{part}.{v.name}": (part, v.name) for v in (*p.inputs, *p.parameters)}
        gives |= {
            f"{part}.{v.name}": (part, v.name) for v in (*p.states, *p.outputs, *p.calculated)
        }
    inputs = {k: [takes[end] for end in ends if end in takes] for k, ends in system.inputs.items()}
    return inputs, {k: gives[end] for k, end in system.outputs.items() if end in gives}


def _different(
    system: System, name: str, ends: list[tuple[str, str]], parts: Mapping[str, Program]
) -> Iterator[Problem]:
    """The problem of an own input whose members cannot be one: other units or start values."""
    members = [v for part, n in ends for v in parts[part].inputs if v.name == n]
    for what, found in (
        ("units", [v.unit for v in members]),
        ("start values", [f"{v.start:g} {v.unit}" for v in members]),
    ):
        if len(set(found)) > 1:
            told = ", ".join(f"{p}.{n} [{x}]" for (p, n), x in zip(ends, found, strict=True))
            message = f"{name!r} stands for inputs of different {what}: {told}"
            remedy = f"give them the same {what}, or names of their own"
            yield system.problem(("inputs", name), message, remedy)
            return


def _of_loop(system: System, links: list[Link], error: AlgebraicLoopError) -> InputError:
    """The problem of a loop, at the connection that closes it."""
    names = [f"{part}.{variable}" for part, variable in error.cycle]
    numbers = {str(link.target): link.connection for link in links}
    message = f"algebraic loop of {', '.join(names)}: {error.reason}"
    remedy = "keep one of the components open, or couple them, with `m4e-fmi run`, which iterates"
    if error.is_singular:  # for a run, too
        remedy = "look at the gains around the loop, its signs and its start values"
    return InputError([system.problem(("connections", numbers[names[0]]), message, remedy)])


def program_at_rest(system: System, *, build_directory: str | Path, tell: Tell) -> Program:
    """As `system_program`, with all components that are no equations settled."""
    named = ComponentSelection(frozenset(), frozenset(), at_rest=True)
    return _program(system, named, build_directory=build_directory, tell=tell)


def at_equilibrium(
    system: System, *, build_directory: str | Path = "build", tell: Tell | None = None
) -> System:
    """The system, with all states of its equations at the equilibrium found from its start values.

    Components without equations are settled with their inputs there, as a run initialises them;
    `tell` gets a warning if an FMU comes to rest only after its start. Unconnected inputs keep
    their start values; loads that depend on time are those at the start time. InputError and
    RunError as from `system_program` and `equilibrium`.
    """
    tell = tell or silent
    program = program_at_rest(system, build_directory=build_directory, tell=tell)
    at = operating_point(program, time=system.simulation.start_time)
    rest = equilibrium(program, at=at)
    for part, law in local_parts(program):
        if isinstance(law, StaticLaw) and law.last.steps:
            tell(
                f"warning: {part.name} is not at rest at its start: it comes to rest "
                f"{law.last.time:g} s later, with its inputs held"
            )
    values = {v.name: float(x) for v, x in zip(program.states, rest.states, strict=True)}
    return _without_angles(system, program).changed(start=values, origin=ORIGIN)


def _without_angles(system: System, program: Program) -> System:
    """The system without start values of angles, in whose place are those of quaternions."""
    angles = {f"{a.owner}.{angle}" for a in attitudes(program) for angle in ATTITUDE}
    components = tuple(
        replace(c, start={k: v for k, v in c.start.items() if f"{c.name}.{k}" not in angles})
        for c in system.components
    )
    return replace(system, components=components)
