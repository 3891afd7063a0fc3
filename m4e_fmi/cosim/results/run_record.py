"""The part of the record that results carry for reports which is known when a run begins.

Its types are in `report.run_report.record`.
"""

from __future__ import annotations

from pathlib import Path

from m4e_fmi.cosim.system.component import ModelFile
from m4e_fmi.cosim.system.simulation import CHECKPOINTS
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Bond, Port
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.doctor import versions
from m4e_fmi.files.limits import LONGEST_NAME
from m4e_fmi.report.graph import graph_of
from m4e_fmi.report.run_report.record import (
    Flow,
    InputFile,
    Product,
    Record,
    carried_record,
    input_file,
)


def attributes_of(prepared: Prepared) -> dict[str, str]:
    """The attributes of the results of a run that begins."""
    system, settings = prepared.system, prepared.system.simulation
    interval = settings.output_interval
    parts = system.components
    starts = {f"{part.name}.{name}": given for part in parts for name, given in part.start.items()}
    return {
        "title": system.name,
        "comment": system.description,
        "algorithm": settings.algorithm,
        "step_size": f"{settings.step_size:g} s",
        "output_interval": "every step" if interval is None else f"{interval:g} s",
        "start_values": "\n".join(f"{name} = {given}" for name, given in starts.items()),
        "changed": "\n".join(
            f"{name} = {starts.get(name, origin.value)} ({origin.name})"
            for name, origin in system.origins.items()
            if (name in starts or origin.value is not None) and name not in CHECKPOINTS
        ),
        "notes": "\n".join(prepared.notes),
        **carried_record(record_of_system(prepared)),
    }


def record_of_system(prepared: Prepared) -> Record:
    """The record of a run of this system."""
    system = prepared.system
    return Record(
        graph=graph_of(prepared),
        flows=tuple(_flow(bond, prepared) for bond in prepared.wiring.bonds),
        inputs=system_inputs(system),
        fmus={
            name: f"{found.path.name}, SHA-256 {found.content}"
            for name, found in prepared.descriptions.items()
        },
        versions=versions(),
    )


def _flow(bond: Bond, prepared: Prepared) -> Flow:
    products = []
    for axis in bond.axes:
        force, velocity = axis.force.source, axis.velocity.source
        factor = axis.share * _to_si(force, prepared) * _to_si(velocity, prepared)
        products.append(Product(str(force), str(velocity), factor))
    first = bond.axes[0].force
    source, target = first.source.component, first.target.component
    return Flow(bond.name, source, target, tuple(products), bond.adds)


def _to_si(port: Port, prepared: Prepared) -> float:
    """SI value over the value of a variable; 1 without a unit."""
    dimension = prepared.descriptions[port.component].variables[port.variable].dimension
    return 1.0 if dimension is None else dimension.factor


def system_inputs(system: System) -> tuple[InputFile, ...]:
    """The system's file and those of its models with their texts, other files without."""
    document = system.document
    models = [c.source.path for c in system.components if isinstance(c.source, ModelFile)]
    named = {system.folder / path: _short(path, system.folder) for path in models}
    found = [input_file(document.path, document.path.name)] if document else []
    found += [input_file(path, name) for path, name in named.items()]
    texts = document.texts(()) if document else ()
    others = {system.folder / text: text for _, text in texts if len(text) < LONGEST_NAME}
    found += [
        input_file(path, name, kept=False) for path, name in others.items() if path not in named
    ]
    return tuple(one for one in found if one)


def _short(path: Path, folder: Path) -> str:
    """A path relative to the system's folder if it is below it, else its name."""
    given = folder / path
    return given.relative_to(folder).as_posix() if given.is_relative_to(folder) else path.name
