"""Described lines as a MoorDyn v2 input file, written without rounding.

Source of the format: the MoorDyn v2 documentation, "Inputs".
"""

from __future__ import annotations

from collections.abc import Sequence

from m4e_adapters.moordyn.config import FreePoint, LineType, MooringConfig, in_space

QUIET = (("0", "writeLog"), ("1", "disableOutput"), ("1", "disableOutTime"))
RELAXATION = (("1", "ICgenDynamic"), ("1e-4", "threshIC"), ("10", "dtIC"))
"""How MoorDyn looks for the static equilibrium where ours was not found: its stationary solver
stops anywhere; the tensions of 10 moments within dtIC/10 must be alike."""
MOVING_WATER = ("1", "WaveKin")  # velocities and accelerations of the water come from outside
NOTHING = FreePoint(position=())  # of which an anchor or a fairlead has the mass and the rest


def point_numbers(config: MooringConfig) -> dict[str, int]:
    """Numbers, from 1, in the table of points: anchors first, then fairleads and free points."""
    return {n: k for k, n in enumerate([*config.anchors, *config.fairleads, *config.points], 1)}


def line_file(config: MooringConfig, *, deepest: float) -> str:
    """The tables of described lines, and the options of water, seabed and initial state.

    `deepest` is the largest depth [m] of the seabed.
    """
    number, water, bed = point_numbers(config), config.water, config.seabed
    assert water is not None
    fixed = [("Fixed", place, NOTHING) for place in config.anchors.values()]
    coupled = [("Coupled", place or (0.0, 0.0), NOTHING) for place in config.fairleads.values()]
    free = [("Free", point.position, point) for point in config.points.values()]
    options = {
        "g": water.gravity,
        "rho": water.density,
        "WtrDpth": deepest,
        "kBot": bed.stiffness,
        "cBot": bed.damping,
        "FrictionCoefficient": bed.friction,
        "FricDamp": bed.friction_damping,
        "TmaxIC": 200.0 if config.static_equilibrium else 0.0,
    }
    return "\n".join(
        [
            *table(
                "LINE TYPES",
                [
                    " ".join([name, *map(repr, _of_type(kind))])
                    for name, kind in config.line_types.items()
                ],
            ),
            *table(
                "POINTS",
                [
                    f"{k} {kind} {' '.join(map(repr, (*in_space(at), *_of_point(point))))}"
                    for k, (kind, at, point) in enumerate([*fixed, *coupled, *free], 1)
                ],
            ),
            *table(
                "LINES",
                [
                    f"{k} {line.type} {number[line.from_]} {number[line.to]} "
                    f"{line.unstretched_length!r} {line.segments} -"
                    for k, line in enumerate(config.lines.values(), 1)
                ],
            ),
            header("OPTIONS"),
            *(f"{value!r} {key}" for key, value in options.items()),
        ]
    )


def header(title: str) -> str:
    """A section's first line."""
    return f"---------------------- {title.upper()} ----------------------"


def table(title: str, rows: Sequence[str]) -> list[str]:
    """The lines of a section with `rows`, below lines for their names and units; none without rows.

    Points always have a section: parted ends get there.
    """
    return [header(title), "-", "-", *rows] if rows or title == "points" else []


def _of_point(point: FreePoint) -> tuple[float, ...]:
    force = in_space(point.force or (0.0, 0.0))
    return point.mass, point.volume, *force, point.drag_area, point.added_mass_coefficient


def _of_type(kind: LineType) -> tuple[float, ...]:
    damping = kind.axial_damping
    return (
        kind.diameter,
        kind.mass_per_length,
        kind.axial_stiffness,
        -(kind.axial_damping_ratio or 0.0) if damping is None else damping,  # MoorDyn's sign
        kind.bending_stiffness,
        kind.drag_coefficient,
        kind.added_mass_coefficient,
        kind.axial_drag_coefficient,
        kind.axial_added_mass_coefficient,
    )
