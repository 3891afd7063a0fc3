"""`m4e-fmi run` co-simulates a system of FMUs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cli.shared.log import (
    add_log,
    detail,
    note,
    print_files,
    progress,
    say,
    show,
    tell_event,
    warn,
)
from m4e_fmi.cli.shared.options import (
    add_options,
    animation_file,
    load_system,
    output_file,
    report_file,
    start_values,
)
from m4e_fmi.coupling_algorithms import algorithm_names, listed
from m4e_fmi.files.file_kinds import FMU_SUFFIX

if TYPE_CHECKING:
    from m4e_fmi.cosim import Outcome, System


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `run`."""
    command.add_argument(
        "system", type=Path, help="a system file (YAML), package (.ssp), or an FMU"
    )
    _add_course(command)
    _add_modes(command)
    add_options(command, "--animate", "--report", "--no-plot")
    add_options(
        command,
        "--native",
        help="build native FMUs of models and other programs (default), or Python ones",
    )
    add_options(command, "--start-value", metavar=("COMPONENT.VARIABLE", "VALUE"))
    add_options(command, "--output-file", "--build-folder")
    add_log(command, events=True)
    command.set_defaults(command=_run)


def _add_course(command: argparse.ArgumentParser) -> None:
    """Add the options of times and steps, and of where a run begins."""
    for flag, text in (
        ("--stop-time", "end of the run"),
        ("--step-size", "time between communication points"),
        ("--output-interval", "time between rows of the results"),
        ("--checkpoint-interval", "simulated time between checkpoints"),
        ("--checkpoint-wall-interval", "wall time between checkpoints"),
    ):
        command.add_argument(flag, type=_time, metavar="S", help=f"{text}; default: as in the file")
    command.add_argument(
        "--algorithm", help=f"{listed(algorithm_names())}; default: as in the file"
    )
    command.add_argument(
        "--resume",
        nargs="?",
        const=True,
        default=False,
        type=Path,
        metavar="CHECKPOINT",
        help="go on from a checkpoint; default: the one beside the results",
    )
    command.add_argument(
        "--start",
        choices=("values", "equilibrium"),
        default="values",
        help="begin with the start values (default), or at the equilibrium found from them, with "
        "components that are no equations settled",
    )


def _add_modes(command: argparse.ArgumentParser) -> None:
    """Add the options of recorded variables, parameter sets and the error estimate."""
    command.add_argument(
        "--variables",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME",
        help="variables to record, as 'buoy.*'; default: all outputs and connected arrays",
    )
    command.add_argument(
        "--parameters",
        type=Path,
        metavar="FILE",
        help="a parameter set: start values in a file (YAML, or SSP's .ssv)",
    )
    command.add_argument(
        "--no-certify",
        dest="certify",
        action="store_false",
        help="estimate no coupling error: no step is made twice, and the results say so",
    )


def _time(text: str) -> float:
    """A time in seconds, of a text that may have a unit."""
    from m4e_fmi.cosim.system.simulation import TIMES, time_of

    try:
        return float(time_of(text))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a valid duration: {TIMES}") from None


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.cosim import at_equilibrium
    from m4e_fmi.files.locks import claimed
    from m4e_fmi.results.results_file import stream_of

    system = _system(options)
    output = output_file(options, system.name)
    with claimed(stream_of(output)):  # and the picture
        if options.start == "equilibrium":
            system = at_equilibrium(system, build_directory=options.build_folder, tell=say)
        _run_to(output, system, options)


def _system(options: argparse.Namespace) -> System:
    """The system with what the command line changes; wrong names of files are told first."""
    from m4e_fmi.cosim import read_parameters
    from m4e_fmi.cosim.system.simulation import CHECKPOINTS

    output = output_file(options, "system")
    animation_file(options, "system")
    report_file(options, output)
    system = load_system(options.system)
    if options.parameters:
        system = system.changed(start=read_parameters(options.parameters), origin="")
    times = ("stop_time", "step_size", "output_interval", "algorithm", *CHECKPOINTS)
    settings = {key: getattr(options, key) for key in times}
    given = start_values(options)
    if options.system.suffix.lower() == FMU_SUFFIX:  # names of its variables may do without it
        owner = f"{system.components[0].name}."
        given = {owner + name.removeprefix(owner): value for name, value in given.items()}
        options.variables = [owner + name.removeprefix(owner) for name in options.variables]
    return system.changed(start=given, origin="command line", **settings)


def _run_to(output: Path, system: System, options: argparse.Namespace) -> None:
    from m4e_fmi.cosim import ExportError, prepare, run
    from m4e_fmi.cosim.results.system_scene import system_scene
    from m4e_fmi.cosim.run.verbs import checkpoint_to_resume

    file = output.absolute()  # an FMU may change the working folder
    animation = animation_file(options, system.name)
    report = report_file(options, output)
    # a checkpoint that is missing or damaged is told before anything is built in place of its FMUs
    checkpoint_to_resume(output, options.resume)
    times = system.simulation
    tell_event(
        "plan",
        name=system.name,
        method=times.algorithm,
        start_time=times.start_time,
        stop_time=times.stop_time,
        step_size=times.step_size,
        output_interval=times.output_interval or times.step_size,
        components=[component.name for component in system.components],
        results=str(output),
    )
    told: list[str] = []

    def listen(line: str) -> None:
        told.append(line)
        say(line)

    prepared = prepare(
        system, build_directory=options.build_folder, native=options.native, tell=listen
    )
    count, links = len(system.components), len(prepared.wiring.links)
    detail(f"{system.name}: {count} FMUs, {links} connected variables")
    animated = animation is not None or (
        report is not None
        and system_scene(prepared.system, prepared.descriptions, prepared.wiring) is not None
    )

    def heed(line: str) -> None:
        told.append(line)
        warn(line)

    try:
        with progress(times.stop_time, start=times.start_time) as moving:
            outcome = run(
                prepared,
                results=output,
                progress=moving,
                variables=options.variables,
                tell=note,
                warn=heed,
                beside=[file.with_suffix(".png"), *filter(None, (animation, report))],
                resume=options.resume,
                certify=options.certify,
                animated=animated,
            )
    except ExportError as error:
        _tell_result(error.outcome, told)
        print_files(filter(None, [error.outcome.path]))
        raise
    _tell_result(outcome, told)
    _write_beside(outcome, (output, file), animation, report, options)


def _tell_result(outcome: Outcome, told: Collection[str]) -> None:
    """Tell the result, doubts that were not `told` yet, and the numerics."""
    from m4e_fmi.report import run_numbers, run_summary, run_text

    numbers, variables = run_numbers(outcome)
    show(run_text(outcome, told), "summary", numbers=numbers, variables=variables)
    detail(run_summary(outcome))
    sys.stdout.flush()  # drawing takes a second, within which a signal may end it


def _write_beside(
    outcome: Outcome,
    output: tuple[Path, Path],
    animation: Path | None,
    report: Path | None,
    options: argparse.Namespace,
) -> None:
    """Draw, animate and report a run, as far as asked for.

    `output` is the file of results as given, and from the root on.
    """
    from m4e_fmi.report import animate_run, plot_run, report_of_run
    from m4e_fmi.results.results_file import as_given

    assert outcome.path is not None
    given, file = output
    files = [outcome.path, as_given(given, file)]
    try:
        if not options.no_plot:
            picture = plot_run(outcome.path, file.with_suffix(".png"))
            files.append(as_given(given.with_suffix(".png"), picture))
        if animation:
            files.append(animate_run(outcome.path, animation))
        if report:
            files.append(report_of_run(outcome.path, report, command=options.given))
    finally:
        print_files(dict.fromkeys(files))
