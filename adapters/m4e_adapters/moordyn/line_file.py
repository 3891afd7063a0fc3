"""MoorDyn v2 input files, written without rounding.

Source of the format: the MoorDyn v2 documentation, "Inputs".
"""

from __future__ import annotations

from collections.abc import Iterable

from m4e_adapters.moordyn.config import MooringConfig, Place, in_space

QUIET = (("0", "writeLog"), ("1", "disableOutput"), ("1", "disableOutTime"))
RELAXATION = (("1", "ICgenDynamic"), ("1e-4", "threshIC"), ("10", "dtIC"))
"""How MoorDyn looks for the static equilibrium where ours was not found: its stationary solver
stops anywhere; the tensions of 10 moments within dtIC/10 must be alike."""
MOVING_WATER = ("1", "WaveKin")  # velocities and accelerations of the water come from outside
NO_CABLE = "0.0 0.0 0.0 0.0"  # mass, volume, drag area and added mass of a point


def line_file(config: MooringConfig, *, time_step: float, scheme: str) -> str:
    """The input file of described lines: anchors first, then fairleads.

    `time_step` [s] is MoorDyn's internal one, of its `scheme`.
    """
    points: dict[str, tuple[str, Place]] = {
        name: ("Fixed", place) for name, place in config.anchors.items()
    }
    for name, place in config.fairleads.items():
        points[name] = ("Coupled", place or (0.0, 0.0))
    number = {name: k + 1 for k, name in enumerate(points)}
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
                "ID Type X Y Z M V CdA CA",
                "(-) (-) (m) (m) (m) (kg) (m^3) (m^2) (-)",
                [
                    f"{number[name]} {kind} {' '.join(map(repr, in_space(at)))} {NO_CABLE}"
                    for name, (kind, at) in points.items()
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
            *(f"{value} {key}" for value, key in _options(config, time_step, scheme)),
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


def _options(config: MooringConfig, time_step: float, scheme: str) -> Iterable[tuple[str, str]]:
    water = config.water
    assert water is not None
    yield from (*QUIET, *RELAXATION)
    if config.moves_water:
        yield MOVING_WATER
    yield "200" if config.static_equilibrium else "0", "TmaxIC"
    for value, key in (
        (water.gravity, "g"),
        (water.density, "rho"),
        (water.depth, "WtrDpth"),
        (config.seabed.stiffness, "kBot"),
        (config.seabed.damping, "cBot"),
        (time_step, "dtM"),
    ):
        yield repr(value), key
    yield scheme, "tScheme"
