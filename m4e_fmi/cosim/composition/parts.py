"""The components that a system's program is of: what each is, and what cannot take part.

Those that are no equations may take part as static laws: their FMUs at rest, and linear about that.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from m4e_fmi.cosim.composition.static_law import AtRest, Inputs, StaticLaw, law_program
from m4e_fmi.cosim.preparation.components import (
    Draft,
    Tell,
    checked_inputs,
    drafted,
    ready_fmus,
    takes_long,
)
from m4e_fmi.cosim.preparation.prepare import available, described, hosts
from m4e_fmi.cosim.preparation.trial_instances import Instances
from m4e_fmi.cosim.ssp import unpack_member
from m4e_fmi.cosim.system.component import Component, FmuFile, Kind, ModelFile, kind_of
from m4e_fmi.cosim.system.start_values import start_values
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Link, Port, Wiring, is_varying
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.limits import MOST_STEPS
from m4e_fmi.fmu import Description, OutputsAtRest, PythonSource, read_description
from m4e_fmi.fmu.export.description import expected_description
from m4e_fmi.fmu.export.native_fmu import carried_program
from m4e_fmi.fmu.importer.reading import Variable, resized
from m4e_fmi.fmu.importer.type_rules import REAL
from m4e_fmi.model import load_model
from m4e_fmi.program import Program

Made = Program | PythonSource
LONGEST = 1e6
"""Time [s] for which FMUs are told to run: some make no step beyond it."""


@dataclass(frozen=True)
class ComponentSelection:
    """Components that are left out, and those that take part by their static law.

    With `at_rest` these are all that are no equations, and steps mean nothing.
    """

    open: frozenset[str]
    settled: frozenset[str]
    at_rest: bool = False


@dataclass(frozen=True)
class Parts:
    """Programs of components by name, what models they are from, descriptions of all components.

    `settled` are those that take part by their static law.
    """

    programs: Mapping[str, Program]
    settled: Collection[str]
    origins: Mapping[str, object]
    descriptions: Mapping[str, Description]


def look_at(
    system: System,
    named: ComponentSelection,
    tell: Tell,
    drawn: Callable[[Component, Tell], Made | None] | None = None,
) -> Parts:
    """All components, those that are not FMUs as `drawn`, or as in a run without `drawn`.

    Components that take long are made last, and only if there are no other problems. InputError
    with all problems of the system.
    """
    drafts = checked_inputs(system)
    problems = list(_unknown(system, named))
    found: dict[str, tuple[Made | None, Description]] = {}
    for component in sorted(system.components, key=lambda c: takes_long(c.source)):
        if problems and takes_long(component.source):
            break
        try:
            found[component.name] = _looked_at(
                system, component, drafts, tell, drawn, unread=named.settled | named.open
            )
        except InputError as error:
            problems += [system.located(component.name, problem) for problem in error.problems]
            continue
        problems += _out_of_place(system, named, component, found[component.name][0])
    if problems:
        raise InputError(list(dict.fromkeys(problems)))
    parts = {c.name: (c, found[c.name][0]) for c in system.components if c.name not in named.open}
    programs = {
        name: made
        for name, (_, made) in parts.items()
        if isinstance(made, Program) and name not in named.settled
    }
    return Parts(
        programs,
        settled=[name for name in parts if name not in programs],
        origins={
            name: load_model(component.source.path)
            for name, (component, _) in parts.items()
            if name in programs and isinstance(component.source, ModelFile)
        },
        descriptions={c.name: found[c.name][1] for c in system.components},
    )


def _looked_at(
    system: System,
    component: Component,
    drafts: Mapping[str, Draft],
    tell: Tell,
    drawn: Callable[[Component, Tell], Made | None] | None,
    *,
    unread: Collection[str],
) -> tuple[Made | None, Description]:
    """A component as it is made (None: an FMU) and described; taken from `drafts` if present.

    FMUs built by this package become the programs that they carry, except those in `unread`.
    """
    name, source = component.name, component.source
    if isinstance(source, FmuFile):
        made, description = _read(source, component, as_program=name not in unread)
        return made, component.described(description)

    def say(line: str) -> None:
        tell(f"{name}: {line}")

    made = drawn(component, say) if drawn else None
    if made is None:
        if (draft := drafts.get(name)) is None:
            draft = drafted(system, component, say)
        for line in draft.lines:
            say(line)
        made = draft.made
    return made, component.described(expected_description(made, Path(f"{name}.fmu")))


def _out_of_place(
    system: System, named: ComponentSelection, component: Component, made: Made | None
) -> Iterator[Problem]:
    """Problems of a component that is no equations but not settled, or the other way round."""
    name = component.name
    if name in named.open:
        return
    if not isinstance(made, Program):
        if name not in named.settled and not named.at_rest:
            yield _no_equations(system, component)
    elif name in named.settled:
        what = "is equations, which take part as they are: there is nothing to be settled"
        remedy = f"leave out --settled {name}"
        yield system.problem(("components", name), f"{name} {what}", remedy)
    elif not named.at_rest and (component.own_step or 0) > system.simulation.step:
        message = (
            f"{name} is stepped every {float(component.own_step or 0):g} s, and holds its outputs "
            "between: one program has no steps"
        )
        remedy = f"leave out its step_size, or keep it open (--open {name})"
        yield system.problem(("components", name, "step_size"), message, remedy)


def _read(
    source: FmuFile, component: Component, *, as_program: bool
) -> tuple[Program | None, Description]:
    """The description of an FMU, which may be packed, and the program that ours carry."""
    if source.member:
        with TemporaryDirectory() as folder:
            path = unpack_member(source.path, source.member, Path(folder))
            return _read(FmuFile(path), component, as_program=as_program)
    description = resized(read_description(source.path), component.start)
    program = carried_program(source.path) if as_program else None
    if program is None:
        return None, description
    known = {v.name for v in (*program.parameters, *program.inputs, *program.states)}
    shown = {v.name for v in (*program.outputs, *program.calculated)}
    if not description.variables.keys() >= known | shown:
        return None, description
    given = ((name, v.start) for name, v in description.variables.items() if name in known)
    return program.with_start({n: float(x) for n, x in given if x is not None}), description


def _unknown(system: System, named: ComponentSelection) -> Iterator[Problem]:
    """Problems of the names that the caller gives."""
    names = [c.name for c in system.components]
    for given, what in ((named.open, "kept open"), (named.settled, "settled")):
        for name in sorted(given.difference(names)):
            message = f"{system.name}: there is no component {name!r} to be {what}"
            yield Problem(message, suggestion(name, names, "components"))
    for name in sorted(named.open & named.settled):
        message = f"{system.name}: {name} cannot be both open and settled"
        yield Problem(message, "settled, it takes part by its static law; open, it is left out")


def _no_equations(system: System, component: Component) -> Problem:
    what = "is an FMU, whose equations are not known"
    if not isinstance(component.source, FmuFile):
        what = "is computed by Python code, not by equations"
    message = f"{component.name} {what}: it cannot be part of one program"
    remedy = (
        f"keep it open (--open {component.name}): what it gives becomes inputs of the rest; take "
        f"what it gives at rest (--settled {component.name}); or couple it, with `m4e-fmi run`"
    )
    return system.problem(("components", component.name), message, remedy)


def stand_ins(
    system: System,
    settled: Collection[str],
    wiring: Wiring,
    descriptions: Mapping[str, Description],
    *,
    build_directory: str | Path,
    tell: Tell,
) -> dict[str, tuple[Program, StaticLaw]]:
    """The static laws of the components `settled`, whose parameters are still to be found.

    Their FMUs are built in `build_directory` as for a run; those of others get processes of their
    own. `descriptions` are of all components. InputError and RunError as from `prepare`.
    """
    found: dict[str, tuple[Program, StaticLaw]] = {}
    rates = set(_rates(wiring, descriptions))
    for component in (_at_rest(c) for c in system.components if c.name in settled):
        name, known = component.name, descriptions[component.name].variables
        links = _real_links(system, wiring, descriptions, name)
        inputs = _inputs(known, links, rates)
        given = {k.source.variable for k in wiring.all_links if k.source.component == name}
        outputs = [v for n, v in known.items() if v.type == REAL and (is_varying(v) or n in given)]

        def warn(line: str, name: str = name) -> None:
            tell(f"{name}: warning: {line}")

        law = StaticLaw(
            name,
            partial(_settling, system, component, outputs, build_directory, tell),
            inputs,
            warn,
            tell,
            outputs=outputs,
            statics=_statics(system, component, descriptions[name]),
        )
        every = [known[target] for target in links]
        found[name] = law_program(name, inputs, every, outputs), law
    return found


def _statics(
    system: System, component: Component, description: Description
) -> Callable[[Mapping[str, float]], OutputsAtRest | None]:
    """Outputs of a component at rest as its kind knows them, by values of some of its inputs."""
    source = component.source
    if not isinstance(source, Kind):
        return lambda _: None
    known = kind_of(source.name).statics(source.config, folder=system.folder)
    if known is None:
        return lambda _: None
    causes, variables = ("input", "parameter"), description.variables.items()
    reals = {n: v for n, v in variables if v.type == REAL and v.causality in causes}
    start = {n: float(v.start or 0.0) for n, v in reals.items()}
    start |= {n: float(v) for n, v in start_values(component, description).items() if n in reals}
    return lambda given: known({**start, **given})


def _settling(
    system: System,
    component: Component,
    outputs: Sequence[Variable],
    build_directory: str | Path,
    tell: Tell,
) -> AtRest:
    """The `outputs` of the FMU of a component at rest."""
    small = replace(
        system, components=(component,), connections=(), inputs={}, outputs={}, scenario={}
    )
    (description,) = (
        own := described(small, ready_fmus(small, build_directory, tell=tell))
    ).values()
    apart, missing = available(small, hosts(small, own))
    for line in missing:
        tell(f"warning: {line}")
    times = system.simulation
    longest = min(LONGEST, MOST_STEPS * times.step_size)
    for_ever = replace(times, stop_time=times.start_time + longest, output_interval=None)
    return AtRest(Instances(component, description, for_ever, apart.get(component.name)), outputs)


def _at_rest(component: Component) -> Component:
    """`component` without what moves by itself."""
    source = component.source
    if not isinstance(source, Kind):
        return component
    config, start = kind_of(source.name).at_rest(source.config, component.start)
    return replace(component, source=replace(source, config=config), start=start)


def _real_links(
    system: System, wiring: Wiring, descriptions: Mapping[str, Description], name: str
) -> dict[str, Link | None]:
    """The connected Real variables of a component with their links; None of the system's inputs."""
    known = descriptions[name].variables
    found: dict[str, Link | None] = {
        link.target.variable: link
        for link in wiring.all_links
        if link.target.component == name
        and link.is_real
        and known[link.target.variable].type == REAL
    }
    ends = [Port.named(text) for texts in system.inputs.values() for text in texts]
    for port in ends:
        if port.component == name and known[port.variable].type == REAL:
            found.setdefault(port.variable, None)
    return found


def _rates(wiring: Wiring, descriptions: Mapping[str, Description]) -> Iterator[Port]:
    """Targets of links that carry a velocity or an acceleration: zero at rest."""
    yield from (axis.velocity.target for bond in wiring.bonds for axis in bond.axes)
    for link in wiring.all_links:
        ends = zip(link.ends, ("output_derivatives", "input_derivatives"), strict=True)
        for port, derivatives in ends:
            description = descriptions[port.component]
            of = description.variables[port.variable].derivative_of
            if of or port.variable in getattr(description, derivatives).values():
                yield link.target
                break


def _inputs(
    known: Mapping[str, Variable], links: Mapping[str, Link | None], rates: Collection[Port]
) -> Inputs:
    """The connected Real inputs by what they do at rest."""
    still = {n: link.offset for n, link in links.items() if link and link.target in rates}
    others = [known[name] for name in links if name not in still]
    varying = [v for v in others if v.causality == "input" or v.variability == "tunable"]
    return Inputs(varying, [v for v in others if v not in varying], still)
