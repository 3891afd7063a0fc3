"""From what a system file says to a mooring."""

from __future__ import annotations

from pathlib import Path

from m4e_adapters.moordyn.config import MooringConfig
from m4e_adapters.moordyn.line_file import line_file
from m4e_adapters.moordyn.mooring import Fairlead, Mooring, internal_step
from m4e_adapters.moordyn.ready_file import ready_mooring
from m4e_adapters.moordyn.stability import Segment


def mooring(config: MooringConfig, *, folder: str | Path = ".") -> Mooring:
    """The mooring that `config` describes, or the file that it names, relative to `folder`.

    InputError if the internal time step is unstable or the file is not supported.
    """
    if config.file is not None:
        return ready_mooring(Path(folder) / config.file, fairleads=config.fairleads)
    segments = _segments(config)
    step = internal_step(segments, scheme=config.solver.scheme, wanted=config.solver.time_step)
    # without nodes between the ends there is nothing that could come to rest
    static = bool(segments) and config.static_equilibrium.duration > 0
    return Mooring(
        text=line_file(config, time_step=step, static=static),
        fairleads=tuple(
            Fairlead(name, x, 0.0, z)
            for name, (x, z) in ((n, p or (0.0, 0.0)) for n, p in config.fairleads.items())
        ),
        lines=tuple(config.lines),
        time_step=step,
        static_duration=config.static_equilibrium.duration if static else 0.0,
    )


def _segments(config: MooringConfig) -> dict[str, Segment]:
    """A segment of every line that has nodes between its ends."""
    found = {}
    for name, line in config.lines.items():
        if line.segments == 1:
            continue
        kind, length = config.line_types[line.type], line.unstretched_length / line.segments
        found[name] = Segment(
            length=length,
            diameter=kind.diameter,
            mass_per_length=kind.mass_per_length,
            axial_stiffness=kind.axial_stiffness,
            damping=kind.damping(length),
            bending_stiffness=kind.bending_stiffness,
            seabed_stiffness=config.seabed.stiffness,
            seabed_damping=config.seabed.damping,
        )
    return found
