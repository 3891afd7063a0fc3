"""`m4e-fmi rao` finds the response of a system to regular waves, or its statistics in a sea."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cli.shared.log import add_log, print_files, say, show_result, warn
from m4e_fmi.cli.shared.options import (
    BUILD_FOLDER,
    add_options,
    finite,
    is_system,
    load_in_waves,
    load_system,
    start_values,
)
from m4e_fmi.errors import InputError

if TYPE_CHECKING:
    from m4e_fmi.analysis import OperatingPoint
    from m4e_fmi.analysis.response import InWaves, Sea

PEAKS = 2.5
"""Peak frequencies up to which forces are computed for a sea."""
ENHANCEMENT = 3.3
FEW, MOST = 2, 100_000


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `rao`."""
    command.add_argument("model", type=Path, metavar="system", help="a system file")
    add_options(command, "--open", "--settled", "--build-folder")
    command.add_argument(
        "--periods",
        nargs="+",
        type=_range,
        action="extend",
        metavar="S",
        help="wave periods, or FIRST:LAST:COUNT; default 4:14:21",
    )
    command.add_argument(
        "--headings",
        nargs="+",
        type=_range,
        action="extend",
        metavar="DEG",
        help="directions that waves travel to, from +X towards +Y; default as in the file",
    )
    command.add_argument(
        "--height",
        type=finite,
        default=0.0,
        metavar="M",
        help="of regular waves, for which drag is linearised; default small waves",
    )
    command.add_argument(
        "--sea",
        nargs="*",
        type=finite,
        metavar="X",
        help="statistics in an irregular sea instead: that of the file, or HEIGHT PERIOD [GAMMA] "
        f"of JONSWAP (significant height, peak period, default {ENHANCEMENT:g})",
    )
    command.add_argument(
        "--outputs", nargs="+", action="extend", metavar="NAME",
        help="outputs or states; default coordinates and powers",
    )  # fmt: skip
    add_options(command, "--start-value", "--json")
    command.add_argument(
        "--output-file", type=Path, metavar="FILE", help="netCDF; default build/NAME_rao.nc"
    )
    add_options(command, "--no-plot")
    add_log(command)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.analysis import equilibrium
    from m4e_fmi.files.file_names import file_stem
    from m4e_fmi.files.writing import check_suffix

    _check(options)
    system = load_system(options.model)
    output = options.output_file or Path(BUILD_FOLDER) / f"{file_stem(system.name)}_rao.nc"
    check_suffix(output, (".nc",), "a response")
    periods = [x for part in options.periods or [_range("4:14:21")] for x in part]
    waves = load_in_waves(system, options, highest=_highest(options, periods))
    if system.scenario:
        warn("warning: the scenario takes no part: a response has no actions")
    point = equilibrium(waves.program, at=start_values(options))
    if options.sea is None:
        _regular(waves, point, periods, output, options)
    else:
        _sea(waves, point, output, options)


def _check(options: argparse.Namespace) -> None:
    """InputError for options that do not go together, or a model in place of a system."""
    if not is_system(options.model):
        message = f"{options.model}: a model alone is in no waves"
        raise InputError.single(message, "give a system with a component in water")
    if options.sea is None:
        return
    if len(options.sea) not in (0, 2, 3):
        message = f"--sea takes HEIGHT PERIOD [GAMMA], or nothing; got {len(options.sea)} numbers"
        raise InputError.single(message)
    if options.height or options.periods:
        raise InputError.single("--sea is an irregular sea", "leave out --height and --periods")
    if options.sea and not (options.sea[0] > 0 and options.sea[1] > 0):
        raise InputError.single("height and peak period of --sea must be positive")
    if options.sea[2:] and not 1.0 <= options.sea[2] <= 10.0:
        raise InputError.single("the peak enhancement of --sea must be between 1 and 10")
    if sum(len(part) for part in options.headings or []) > 1:
        raise InputError.single("--sea has one heading", "call it once for each")


def _highest(options: argparse.Namespace, periods: list[float]) -> float:
    """The frequency [rad/s] that forces of waves are needed up to."""
    if options.sea is None:
        shortest = min(periods)
        if not shortest > 0:
            raise InputError.single(f"wave periods must be positive, got {shortest:g} s")
        return 2.0 * math.pi / shortest
    return PEAKS * 2.0 * math.pi / options.sea[1] if options.sea else 0.0


def _directions(options: argparse.Namespace) -> list[float] | None:
    if not options.headings:
        return None
    return [math.radians(x) for part in options.headings for x in part]


def _regular(
    waves: InWaves,
    point: OperatingPoint,
    periods: list[float],
    output: Path,
    options: argparse.Namespace,
) -> None:
    from m4e_fmi.analysis.response import wave_response
    from m4e_fmi.report import plot_waves, wave_json, wave_text, write_waves

    response = wave_response(
        waves,
        point,
        periods=periods,
        directions=_directions(options),
        outputs=options.outputs,
        height=options.height,
        progress=say,
    )
    files = [write_waves(response, output)]
    if not options.no_plot:
        files.append(plot_waves(response, output.with_suffix(".png")))

    show_result(wave_text(response), wave_json(response), options)
    print_files(files, options)


def _sea(waves: InWaves, point: OperatingPoint, output: Path, options: argparse.Namespace) -> None:
    from m4e_fmi.analysis.response import sea_response
    from m4e_fmi.report import sea_json, sea_text, write_sea

    sea = _given_sea(waves, point, options)
    response = sea_response(waves, point, sea, outputs=options.outputs, progress=say)
    files = [write_sea(response, output)]

    show_result(sea_text(response), sea_json(response), options)
    print_files(files, options)


def _given_sea(waves: InWaves, point: OperatingPoint, options: argparse.Namespace) -> Sea:
    directions = _directions(options)
    if not options.sea:
        own = waves.own_sea(point)
        return own.turned_to(directions[0]) if directions else own
    height, period, *enhancement = options.sea
    angle = directions[0] if directions else waves.own_direction(point)
    return waves.jonswap(height, period, enhancement[0] if enhancement else ENHANCEMENT, angle)


def _range(text: str) -> list[float]:
    """The numbers of ``4`` or ``4:14:21``; argparse's error for anything else."""
    parts = text.split(":")
    if len(parts) == 1:
        return [finite(text)]
    count = int(parts[2]) if len(parts) == 3 and parts[2].isdigit() else 0
    if not FEW <= count <= MOST:
        message = f"expected a number or FIRST:LAST:COUNT, as 4:14:21, got {text!r}"
        raise argparse.ArgumentTypeError(message)
    first, last = finite(parts[0]), finite(parts[1])
    return [first + (last - first) * k / (count - 1) for k in range(count)]
