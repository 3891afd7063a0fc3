"""The mooring FMU at rest: outputs with derivatives by places of fairleads, and a report."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_adapters import moordyn
from m4e_adapters.moordyn import Mooring, MooringConfig
from m4e_adapters.moordyn.plausibility import below_seabed, misplaced, unplaced
from m4e_adapters.moordyn.rest import too_long
from m4e_adapters.moordyn.resting import LinesAtRest, Resting
from m4e_adapters.moordyn.survey import survey
from m4e_fmi.analysis.mooring_data import MooringData
from m4e_fmi.fmu import OutputsAtRest

Found = Iterator[tuple[str, float, np.ndarray]]
"""Names of outputs, their values, and their derivatives (3 f,)."""
Shown = Callable[[Mooring, str], Iterable[int]]
"""Numbers of the nodes of a line whose places are outputs."""


def statics(
    config: MooringConfig, *, folder: Path, shown: Shown
) -> Callable[[Mapping[str, float]], OutputsAtRest | None] | None:
    """A function from values of inputs to the outputs at rest, None where MoorDyn alone knows them.

    It gives None where no equilibrium is found, or lines have parted or are moved.
    """
    mooring = moordyn.mooring(config, folder=folder)
    if not mooring.net or not mooring.at_rest or mooring.sea or mooring.moving or mooring.winches:
        return None
    lines = LinesAtRest(mooring.net)
    inputs = {
        f"{f.name}.{axis}": 3 * k + i
        for k, f in enumerate(mooring.fairleads)
        for i, axis in enumerate("xyz")
        if f.moves_in_space or axis != "y"
    }
    speeds = {".v".join(name.rsplit(".", 1)) for name in inputs}

    def at(given: Mapping[str, float]) -> OutputsAtRest | None:
        if any(v for n, v in given.items() if n in speeds or n.endswith(".parted")):
            return None
        whole = [given.get(f"{f.name}.{a}", f.y) for f in mooring.fairleads for a in "xyz"]
        places = np.array(whole, dtype=float).reshape(-1, 3)
        if (found := lines.at(places)) is None:
            return None
        outputs = list(_outputs(mooring, found, shown))
        return OutputsAtRest(
            {name: value for name, value, _ in outputs},
            {name: {output: float(s[k]) for output, _, s in outputs} for name, k in inputs.items()},
            _warnings(mooring, found, places),
        )

    return at


def mooring_data(
    config: MooringConfig,
    *,
    title: str,
    folder: Path,
    given: Mapping[str, float],
    about: Sequence[float] | None,
    directions: Sequence[float],
) -> MooringData:
    """The mooring in static equilibrium in still water, with the inputs that are `given`."""
    mooring = moordyn.mooring(config, folder=folder)
    names = [(f, axis) for f in mooring.fairleads for axis in "xyz"]
    places = [given.get(f"{f.name}.{axis}", getattr(f, axis)) for f, axis in names]
    strengths = {
        name: getattr(config.line_types[line.type], "breaking_strength", None) or np.nan
        for name, line in config.lines.items()
    }
    data = survey(
        mooring,
        np.array(places, dtype=float).reshape(-1, 3),
        title=title,
        strengths=strengths,
        about=about,
        directions=directions,
    )
    note = ("in still water: its waves and current are left out",) if config.moves_water else ()
    return replace(data, notes=(*data.notes, *note))


def _outputs(mooring: Mooring, found: Resting, shown: Shown) -> Found:
    """The forces on fairleads, tensions at ends, and places of nodes."""
    for k, fairlead in enumerate(mooring.fairleads):
        for i, axis in enumerate("xyz"):
            yield f"{fairlead.name}.force_{axis}", found.force[k, i], found.force_slopes[k, i]
    for k, line in enumerate(mooring.lines):
        for n, end in enumerate(("anchor", "fairlead")):
            force = found.ends[k, n]
            tension = float(np.linalg.norm(force))
            slopes = force @ found.end_slopes[k, n] / (tension or 1.0)
            yield f"{line}.{end}_tension", tension, slopes
        for number, node in enumerate(shown(mooring, line), start=1):
            for i, axis in enumerate("xyz"):
                place, slopes = found.nodes[k][node, i], found.node_slopes[k][node, i]
                yield f"{line}.node_{axis}[{number}]", place, slopes


def _warnings(mooring: Mooring, found: Resting, places: np.ndarray) -> Iterator[str]:
    """Those of a start with the fairleads at `places` (f, 3) [m]."""
    position = [
        (x, y, z) if f.moves_in_space else (x, z)
        for f, (x, y, z) in zip(mooring.fairleads, places.tolist(), strict=True)
    ]
    names, drawn = [f.name for f in mooring.fairleads], [(f.name, *f.place) for f in mooring.drawn]
    yield from mooring.notes
    yield from unplaced(names, position, [f.name for f in mooring.fairleads if f.placed])
    yield from below_seabed(names, position, mooring.bed)
    yield from too_long(found.net, mooring.lines)
    yield from misplaced(drawn, position, shortest=min(line["length"] for line in found.net.lines))
