"""The mooring FMU at rest: outputs with derivatives by places of fairleads, and a report."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from m4e_adapters import moordyn
from m4e_adapters.moordyn import Mooring, MooringConfig
from m4e_adapters.moordyn.plausibility import below_seabed, high_anchors, misplaced, unplaced
from m4e_adapters.moordyn.rest import lying, too_long
from m4e_adapters.moordyn.resting import LinesAtRest, Resting, tensions
from m4e_adapters.moordyn.statics import Net
from m4e_adapters.moordyn.survey import survey
from m4e_fmi.analysis.mooring_data import MooringData
from m4e_fmi.fmu import OutputsAtRest

State = tuple[np.ndarray, np.ndarray, list[np.ndarray]]
"""Forces on fairleads (f, 3) [N], at ends (lines, 2, 3) [N], and nodes (n, 3) [m] of each line."""
Shown = Callable[[Mooring, str], Iterable[int]]
"""Numbers of the nodes of a line that are outputs."""
SAFEST = 1e3
"""The largest safety factor, as of the FMU."""
STEP = 1e-3
"""[m] Along the derivatives of a state, for those of what is computed from it."""


def statics(
    config: MooringConfig, *, folder: Path, shown: Shown
) -> Callable[[Mapping[str, float]], OutputsAtRest | None] | None:
    """A function from values of inputs to the outputs at rest, None where MoorDyn alone knows them.

    It gives None where no equilibrium is found, or lines have parted or are moved.
    """
    mooring = moordyn.mooring(config, folder=folder)
    if not mooring.net or not mooring.at_rest or mooring.sea or mooring.moving:
        return None
    net, winches = mooring.net, {k: mooring.lines[k] for k in mooring.winches}
    lines = LinesAtRest(net)
    inputs = {
        f"{f.name}.{axis}": 3 * k + i
        for k, f in enumerate(mooring.fairleads)
        for i, axis in enumerate("xyz")
        if f.moves_in_space or axis != "y"
    }
    speeds = {".v".join(name.rsplit(".", 1)) for name in inputs}
    speeds |= {f"{line}.length_rate" for line in winches.values()}

    def at(given: Mapping[str, float]) -> OutputsAtRest | None:
        if any(v for n, v in given.items() if n in speeds or n.endswith(".parted")):
            return None
        for k, line in winches.items():
            net["lines"][k]["length"] = given[f"{line}.length"]
        whole = [given.get(f"{f.name}.{a}", f.y) for f in mooring.fairleads for a in "xyz"]
        places = np.array(whole, dtype=float).reshape(-1, 3)
        if (found := lines.at(places)) is None:
            return None

        def outputs(part: float, k: int) -> dict[str, float]:
            slopes = (found.force_slopes, found.end_slopes, *found.node_slopes)
            force, ends, *nodes = (
                now + part * slope[..., k]
                for now, slope in zip((found.force, found.ends, *found.nodes), slopes, strict=True)
            )
            state = (force, ends, nodes)
            return {name: float(x) for name, x in _outputs(mooring, found.net, state, shown)}

        pairs = {name: (outputs(STEP, k), outputs(-STEP, k)) for name, k in inputs.items()}
        return OutputsAtRest(
            outputs(0.0, 0),
            {n: {y: (a[y] - b[y]) / (2.0 * STEP) for y in a} for n, (a, b) in pairs.items()},
            _warnings(mooring, found, places),
        )

    return at


def mooring_data(
    config: MooringConfig,
    *,
    title: str,
    folder: Path,
    given: Mapping[str, float],
    **asked: Any,
) -> MooringData:
    """The mooring in static equilibrium in still water, with the inputs that are `given`."""
    mooring = moordyn.mooring(config, folder=folder)
    names = [(f, axis) for f in mooring.fairleads for axis in "xyz"]
    places = [given.get(f"{f.name}.{axis}", getattr(f, axis)) for f, axis in names]
    net, note = mooring.net, []
    if net:
        given_lengths = [given.get(f"{name}.length") for name in mooring.lines]
        pairs = zip(net["lines"], given_lengths, strict=True)
        lines = [{**line, "length": length or line["length"]} for line, length in pairs]
        mooring = replace(mooring, net={**net, "lines": lines})
        note += high_anchors(net["points"], mooring.bed)
    data = survey(mooring, np.array(places, dtype=float).reshape(-1, 3), title=title, **asked)
    if config.moves_water:
        note.append("in still water: its waves and current are left out")
    note += [f"{n} is left out" for n, value in given.items() if n.endswith(".parted") and value]
    return replace(data, notes=(*data.notes, *note))


def _outputs(mooring: Mooring, net: Net, state: State, shown: Shown) -> Iterator[tuple[str, float]]:
    """All outputs with their values, and some that the FMU may not have."""
    forces, ends, nodes = state
    for fairlead, force in zip(mooring.fairleads, forces, strict=True):
        yield from _vector(f"{fairlead.name}.force_", force)
    for k, name in enumerate(mooring.lines):
        line, at = net.lines[k], nodes[k]
        low, high = np.linalg.norm(ends[k], axis=1)
        yield from ((f"{name}.anchor_tension", low), (f"{name}.fairlead_tension", high))
        pull = tensions(line, at)
        pull = np.vstack([pull[:1], (pull[1:] + pull[:-1]) / 2.0, pull[-1:]])
        for number, node in enumerate(shown(mooring, name), start=1):
            for axis, x in zip("xyz", at[node], strict=True):
                yield f"{name}.node_{axis}[{number}]", x
            yield f"{name}.tension[{number}]", float(np.linalg.norm(pull[node]))
        yield f"{name}.touchdown", lying((at[:, 2] - net.bed).tolist(), line["length"])
        share = max(low, high) / mooring.strengths.get(name, np.inf)
        yield f"{name}.safety_factor", 1.0 / max(share, 1.0 / SAFEST)
    for name, number in mooring.points.items():
        line, end = mooring.ends_at(number)[0]
        yield from _vector(f"{name}.", nodes[line][-end])
    for name, number in mooring.anchors.items():
        force = sum((ends[at] for at in mooring.ends_at(number)), np.zeros(3))
        yield from _vector(f"{name}.force_", force)
        yield f"{name}.uplift_angle", max(0.0, np.arctan2(force[2], np.hypot(*force[:2])))


def _vector(name: str, vector: np.ndarray) -> Iterator[tuple[str, float]]:
    return ((name + axis, x) for axis, x in zip("xyz", vector, strict=True))


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
