"""Components that are no equations as static laws: their FMUs at rest, and linear about that."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from m4e_fmi.cosim.composition.at_rest import AtRest
from m4e_fmi.cosim.composition.static_law import Inputs, StaticLaw, law_program
from m4e_fmi.cosim.connections.links import Link, Port, Wiring, is_varying
from m4e_fmi.cosim.preparation.components import Tell, ready_fmus
from m4e_fmi.cosim.preparation.hosts import available, hosts
from m4e_fmi.cosim.preparation.surroundings import is_of_waves
from m4e_fmi.cosim.preparation.trial_instances import Instances
from m4e_fmi.cosim.system.component import Component, Kind
from m4e_fmi.cosim.system.system import System
from m4e_fmi.files.limits import MOST_STEPS
from m4e_fmi.fmu import Description, read_description
from m4e_fmi.fmu.importer.reading import Variable, resized
from m4e_fmi.fmu.importer.type_rules import REAL
from m4e_fmi.program import Program

LONGEST = 1e6
"""Time [s] for which FMUs are told to run: some make no step beyond it."""


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
    if not settled:
        return {}
    small = replace(
        system,
        components=tuple(_in_still_water(c) for c in system.components if c.name in settled),
        connections=(),
        inputs={},
        outputs={},
        buses={},
        scenario={},
    )
    fmus = ready_fmus(small, build_directory, tell=tell)
    own: dict[str, Description] = {}
    for component in small.components:
        read = resized(read_description(fmus[component.name].path), component.start)
        own[component.name] = component.described(read)
    apart, missing = available(small, hosts(small, own))
    times = system.simulation
    longest = min(LONGEST, MOST_STEPS * times.step_size)
    for_ever = replace(times, stop_time=times.start_time + longest, output_interval=None)
    for line in missing:
        tell(f"warning: {line}")
    found: dict[str, tuple[Program, StaticLaw]] = {}
    for component in small.components:
        name, description = component.name, own[component.name]
        links = _real_links(system, wiring, descriptions, name)
        known = description.variables
        inputs = _inputs(known, links, set(_rates(wiring, descriptions)))
        outputs = list(_outputs(description, wiring, name))
        new = Instances(component, description, for_ever, apart.get(name))

        def warn(line: str, name: str = name) -> None:
            tell(f"{name}: warning: {line}")

        law = StaticLaw(name, AtRest(new, outputs), inputs, warn, tell)
        every = [known[target] for target in links]
        found[name] = law_program(name, inputs, every, outputs), law
    return found


def _in_still_water(component: Component) -> Component:
    """`component` without waves, if its kind's configuration can leave them out."""
    source = component.source
    calm = getattr(source.config, "in_still_water", None) if isinstance(source, Kind) else None
    if not isinstance(source, Kind) or calm is None:
        return component
    start = {name: value for name, value in component.start.items() if not is_of_waves(name)}
    return replace(component, source=replace(source, config=calm()), start=start)


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


def _outputs(description: Description, wiring: Wiring, name: str) -> Iterator[Variable]:
    """The Real outputs of a component, and what else of it is Real and connected."""
    given = {link.source.variable for link in wiring.all_links if link.source.component == name}
    for v in description.variables.values():
        if v.type == REAL and (is_varying(v) or v.name in given):
            yield v
