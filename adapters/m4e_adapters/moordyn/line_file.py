"""MoorDyn v2 input files, written without rounding.

Source of the format: the MoorDyn v2 documentation, "Inputs".
"""

from __future__ import annotations

from collections.abc import Iterable

from m4e_adapters.moordyn.bathymetry import FILE
from m4e_adapters.moordyn.config import FreePoint, MooringConfig, in_space

QUIET = (("0", "writeLog"), ("1", "disableOutput"), ("1", "disableOutTime"))
RELAXATION = (("1", "ICgenDynamic"), ("1e-4", "threshIC"), ("10", "dtIC"))
"""How MoorDyn looks for the static equilibrium where ours was not found: its stationary solver
stops anywhere; the tensions of 10 moments within dtIC/10 must be alike."""
MOVING_WATER = ("1", "WaveKin")  # velocities and accelerations of the water come from outside
NOTHING = FreePoint(position=())  # of which an anchor or a fairlead has the mass and the rest


def point_numbers(config: MooringConfig) -> dict[str, int]:
    """Numbers, from 1, in the table of points: anchors first, then fairleads and free points."""
    return {n: k for k, n in enumerate([*config.anchors, *config.fairleads, *config.points], 1)}


def line_file(config: MooringConfig, *, time_step: float, scheme: str, deepest: float) -> str:
    """The input file of described lines.

    `time_step` [s] is MoorDyn's internal one, of its `scheme`; `deepest` is the largest depth [m]
    of the seabed.
    """
    number = point_numbers(config)
    fixed = [("Fixed", place, NOTHING) for place in config.anchors.values()]
    coupled = [("Coupled", place or (0.0, 0.0), NOTHING) for place in config.fairleads.values()]
    free = [("Free", point.position, point) for point in config.points.values()]
    return "\n".join(
        [
            "MoorDyn v2 input file",
            *_section(
                "LINE TYPES",
                "Name Diam MassDen EA BA/-zeta EI Cd Ca CdAx CaAx",
                "(-) (m) (kg/m) (N) (N-s/-) (N-m^2) (-) (-) (-) (-)",
                [_line_type(name, config) for name in config.line_types],
            ),
            *_section(
                "POINTS",
                "ID Type X Y Z M V FX FY FZ CdA CA",
                "(-) (-) (m) (m) (m) (kg) (m^3) (N) (N) (N) (m^2) (-)",
                [
                    f"{k} {kind} {' '.join(map(repr, (*in_space(at), *_of_point(point))))}"
                    for k, (kind, at, point) in enumerate([*fixed, *coupled, *free], 1)
                ],
            ),
            *_section(
                "LINES",
                "ID LineType AttachA AttachB UnstrLen NumSegs Outputs",
                "(-) (-) (-) (-) (m) (-) (-)",
                [
                    f"{k + 1} {line.type} {number[line.from_]} {number[line.to]} "
                    f"{line.unstretched_length!r} {line.segments} -"
                    for k, line in enumerate(config.lines.values())
                ],
            ),
            header("OPTIONS"),
            *(f"{value} {key}" for value, key in _options(config, time_step, scheme, deepest)),
            header("OUTPUTS"),
            header("END"),
            "",
        ]
    )


def header(title: str) -> str:
    """A section's first line."""
    return f"---------------------- {title} ----------------------"


def _section(title: str, names: str, units: str, rows: Iterable[str]) -> list[str]:
    return [header(title), names, units, *rows]


def _of_point(point: FreePoint) -> tuple[float, ...]:
    force = in_space(point.force or (0.0, 0.0))
    return point.mass, point.volume, *force, point.drag_area, point.added_mass_coefficient


def _line_type(name: str, config: MooringConfig) -> str:
    kind = config.line_types[name]
    # MoorDyn reads a negative damping as a damping ratio
    damping = kind.axial_damping
    if damping is None:
        damping = -(kind.axial_damping_ratio or 0.0)
    values = (
        kind.diameter,
        kind.mass_per_length,
        kind.axial_stiffness,
        damping,
        kind.bending_stiffness,
        kind.drag_coefficient,
        kind.added_mass_coefficient,
        kind.axial_drag_coefficient,
        kind.axial_added_mass_coefficient,
    )
    return " ".join([name, *map(repr, values)])


def _options(
    config: MooringConfig, time_step: float, scheme: str, deepest: float
) -> Iterable[tuple[str, str]]:
    water, bed = config.water, config.seabed
    assert water is not None
    yield from (*QUIET, *RELAXATION)
    if config.moves_water:
        yield MOVING_WATER
    yield "200" if config.static_equilibrium else "0", "TmaxIC"
    for value, key in (
        (water.gravity, "g"),
        (water.density, "rho"),
        (deepest, "WtrDpth"),
        (bed.stiffness, "kBot"),
        (bed.damping, "cBot"),
        (bed.friction, "FrictionCoefficient"),
        (bed.friction_damping, "FricDamp"),
        (time_step, "dtM"),
    ):
        yield repr(value), key
    yield scheme, "tScheme"
    if bed.bathymetry is not None:
        yield FILE, "SeafloorFile"
