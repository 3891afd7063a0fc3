"""Mooring lines of a system, or of a file of their own, in static equilibrium."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from m4e_fmi.cosim.composition.compose import at_equilibrium, program_at_rest
from m4e_fmi.cosim.composition.static_law import AT_REST
from m4e_fmi.cosim.preparation.components import Tell, silent
from m4e_fmi.cosim.system.component import Kind, kind_of, kinds
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.system_file import load_system
from m4e_fmi.errors import YAML_SUFFIXES, InputError, suggestion
from m4e_fmi.files.file_kinds import SSP_SUFFIX

if TYPE_CHECKING:
    from m4e_fmi.analysis.mooring_data import MooringData

SYSTEMS = (*YAML_SUFFIXES, ".json", SSP_SUFFIX)


def mooring(
    source: System | str | Path,
    *,
    component: str = "",
    about: Sequence[float] | None = None,
    directions: Sequence[float] = (0.0, math.pi),
    fairleads: Sequence[str] = (),
    start: str = "values",
    build_directory: str | Path = "build",
    tell: Tell | None = None,
) -> MooringData:
    """The mooring lines of a system, or of a file of their own, in static equilibrium.

    `component` is that of several moorings of a system; `about` (x, y, z) [m] the point of their
    force and stiffness, by default the mean of the fairleads; `directions` [rad], from X to Y, are
    those in which the fairleads are moved, or only those named in `fairleads`. `start` is "values"
    for fairleads where the system starts, "equilibrium" where it is at rest. InputError if there
    are no lines, or not one mooring to choose; RunError if they have no equilibrium.
    """
    asked: dict[str, Any] = {"about": about, "directions": directions, "moved": fairleads}
    if not isinstance(source, System):
        path = Path(source)
        if path.suffix.lower() not in SYSTEMS:
            return _of_file(path, asked)
        source = load_system(path)
    found = {
        c.name: (make, c.source.config)
        for c in source.components
        if isinstance(c.source, Kind) and (make := kind_of(c.source.name).mooring)
    }
    chosen = component or (next(iter(found)) if len(found) == 1 else "")
    if chosen not in found:
        message = f"no mooring {chosen!r}" if chosen else f"{len(found) or 'no'} moorings"
        remedy = suggestion(chosen, found) if found else "give a system with a kind of mooring"
        raise InputError.single(f"{source.name}: {message}", remedy)
    given = _inputs(source, chosen, start, build_directory, tell or silent)
    make, config = found[chosen]
    try:
        return make(config, title=source.name, folder=source.folder, given=given, **asked)
    except InputError as error:
        raise InputError([source.located(chosen, p) for p in error.problems]) from None


def _of_file(path: Path, asked: Mapping[str, Any]) -> MooringData:
    for kind in map(kind_of, sorted(kinds())):
        if kind.mooring and kind.config_of_file:
            config = kind.config_of_file(path, progress=silent, depth=None)
            return kind.mooring(config, title=path.stem, folder=path.parent, given={}, **asked)
    raise InputError.single("no kind of FMU that is installed reads mooring lines")


def _inputs(
    system: System, name: str, start: str, build_directory: str | Path, tell: Tell
) -> dict[str, float]:
    """The connected inputs of a component where the system starts, or is at rest."""

    def hear(line: str) -> None:
        if not line.startswith("note: "):  # on what the law of a settled component leaves out
            tell(line)

    if start == "equilibrium":
        system = at_equilibrium(system, build_directory=build_directory, tell=hear)
    program = program_at_rest(system, build_directory=build_directory, tell=hear)
    prefix = f"{name}.{AT_REST}"
    given = next(c.start for c in system.components if c.name == name)
    own = {n: float(value) for n, value in given.items() if isinstance(value, (int, float))}
    if left := given.keys() - own.keys():
        tell(f"warning: start values are left out: {', '.join(sorted(left))}")
    values = {v.name: v.start for v in program.parameters if v.name.startswith(prefix)}
    return own | {name.removeprefix(prefix): value for name, value in values.items()}
