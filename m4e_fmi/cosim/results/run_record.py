"""The record that results carry for reports, of a run that begins."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

from packaging.requirements import Requirement

import m4e_fmi
from m4e_fmi.cosim.connections.links import Axis, Bond, Port
from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.system.component import ModelFile
from m4e_fmi.cosim.system.system import System
from m4e_fmi.report.graph import graph_of
from m4e_fmi.report.run_report.record import LONGEST, Flow, InputFile, Product, Record

SEED = "seed"
"""The key of random numbers in system files."""


def record_of_system(prepared: Prepared) -> Record:
    """The record of a run of this system."""
    system = prepared.system
    return Record(
        graph=graph_of(prepared),
        flows=tuple(_flow(bond, prepared) for bond in prepared.wiring.bonds),
        inputs=tuple(_inputs(system)),
        fmus={
            name: f"{found.path.name}, SHA-256 {found.content}"
            for name, found in prepared.descriptions.items()
        },
        seeds=dict(_seeds(system.document.data, "")) if system.document else {},
        versions=versions(),
    )


def versions() -> dict[str, str]:
    """Versions of m4e_fmi, of Python and the platform, and of the packages that it requires."""
    found = {
        "m4e_fmi": m4e_fmi.__version__,
        "Python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
    }
    with suppress(PackageNotFoundError):  # a source tree that is not installed
        for text in requires("m4e_fmi") or ():
            needed = Requirement(text)
            if needed.marker is None or needed.marker.evaluate({"extra": ""}):
                with suppress(PackageNotFoundError):
                    found[needed.name] = version(needed.name)
    return found


def _flow(bond: Bond, prepared: Prepared) -> Flow:
    force = bond.axes[0].force
    products = tuple(_product(axis, prepared) for axis in bond.axes)
    return Flow(bond.name, force.source.component, force.target.component, products, bond.adds)


def _product(axis: Axis, prepared: Prepared) -> Product:
    force, velocity = axis.force.source, axis.velocity.source
    factor = axis.share * _to_si(force, prepared) * _to_si(velocity, prepared)
    return Product(str(force), str(velocity), factor)


def _to_si(port: Port, prepared: Prepared) -> float:
    """SI value over the value of a variable; 1 without a unit."""
    dimension = prepared.descriptions[port.component].variables[port.variable].dimension
    return 1.0 if dimension is None else dimension.factor


def _inputs(system: System) -> Iterator[InputFile]:
    """The system's file and those of its models with their texts, other files without."""
    document = system.document
    models = [c.source.path for c in system.components if isinstance(c.source, ModelFile)]
    if document is None:
        yield from (found for path in dict.fromkeys(models) if (found := _file(path, path.name)))
        return
    if found := _file(document.path, document.path.name):
        yield found
    texts = {system.folder / path: str(path) for path in models}
    others = {system.folder / text: text for _, text in document.texts(()) if len(text) < 200}
    for path, name in {**texts, **others}.items():
        if found := _file(path, name, kept=path in texts):
            yield found


def _file(path: Path, name: str, *, kept: bool = True) -> InputFile | None:
    """A file, with its text if that is `kept`; None if there is no such file."""
    try:
        data = path.read_bytes() if path.is_file() else None
    except (OSError, ValueError):
        return None
    if data is None:
        return None
    text = None
    if kept and len(data) <= LONGEST:
        text = data.decode("utf-8-sig", errors="replace").replace("\r\n", "\n")
    return InputFile(name, hashlib.sha256(data).hexdigest(), text)


def _seeds(value: object, place: str) -> Iterator[tuple[str, str]]:
    """Seeds of random numbers below a value of a system's file, with their places in it."""
    if isinstance(value, dict | list):
        items = value.items() if isinstance(value, dict) else enumerate(value)
        for key, member in items:
            if key == SEED:
                yield f"{place}{key}", str(member)
            yield from _seeds(member, f"{place}{key}.")
