"""`m4e-fmi simulate` simulates one model, or a system as one program, in this process."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cli.shared.options import (
    MODEL_OR_SYSTEM,
    add_open,
    add_output_file,
    add_start_values,
    is_system,
    load_equations,
    load_program,
    load_system,
    output_file,
    print_files,
    start_values,
)
from m4e_fmi.errors import InputError

if TYPE_CHECKING:
    from m4e_fmi.cosim import System
    from m4e_fmi.model import Model
    from m4e_fmi.program import Program


def add(commands: argparse._SubParsersAction) -> None:
    """Add `simulate` to the command line."""
    command = commands.add_parser(
        "simulate", help="simulate one model, or a system as one program, in this process"
    )
    command.add_argument("model", type=Path, help=MODEL_OR_SYSTEM)
    add_open(command)
    for flag, text in (("--stop-time", "10 s"), ("--output-interval", "0.01 s")):
        command.add_argument(
            flag, type=float, metavar="S", help=f"default {text}; of a system as in its file"
        )
    command.add_argument("--tolerance", type=float, default=1e-8, help="default 1e-8")
    command.add_argument(
        "--method",
        default="dop853",
        help="dop853 (default), rk45, rodas (stiff), rk4 (fixed steps), python, or SciPy's, as "
        "scipy.RK45",
    )
    command.add_argument(
        "--step-size", type=float, metavar="S", help="of rk4, at most; default the output interval"
    )
    for flag, text in (
        ("--event", "report sign changes of this output or state, as load.STOP.gap at contact"),
        ("--stop-at", "end when this output or state changes sign"),
    ):
        command.add_argument(flag, action="append", default=[], metavar="NAME", help=text)
    add_start_values(command, "NAME")
    add_output_file(command)
    command.add_argument(
        "--animate",
        nargs="?",
        type=Path,
        const=Path(),
        metavar="FILE",
        help="write an animation (.html or .gif); default build/NAME.html",
    )
    command.add_argument("--no-plot", action="store_true", help="no picture beside the results")
    command.add_argument(
        "--variables",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME",
        help="variables in the picture; default the main ones",
    )
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.files.locks import claimed
    from m4e_fmi.program import Program
    from m4e_fmi.results.results_file import stream_of

    source, name = _source(options)
    output = output_file(options, name)
    animation = _animation_file(options, name)
    if animation and isinstance(source, Program):
        message = "--animate is for a model: bodies of a system are drawn one model at a time"
        raise InputError.single(message, "leave it out")
    with claimed(stream_of(output)):  # and the pictures
        _simulate_to(output, animation, source, options)


def _source(options: argparse.Namespace) -> tuple[Model | Program, str]:
    """The model, or the program of the system, and a name for the results.

    Times that are not given become those of the system, or the default.
    """
    stop_time, interval = 10.0, 0.01
    if is_system(options.model):
        system = load_system(options.model)
        times = system.simulation
        if times.start_time:
            message = f"start_time is {times.start_time:g} s: a program starts at 0"
            raise InputError([system.problem(("simulation", "start_time"), message, "set it to 0")])
        stop_time, interval = times.stop_time, times.output_interval or times.step_size
        program = load_program(system, options)
        _warn_of_start(system, program, options)
        found: tuple[Model | Program, str] = program, f"{system.name}_whole"
        if system.scenario:
            print(
                "warning: the scenario takes no part: one program has no actions", file=sys.stderr
            )
    else:
        model = load_equations(options)
        found = model, model.name
    if options.stop_time is None:
        options.stop_time = stop_time
    if options.output_interval is None:
        options.output_interval = interval
    return found


def _warn_of_start(system: System, program: Program, options: argparse.Namespace) -> None:
    """Tell what a run tells of floating bodies that are not balanced at the start."""
    from m4e_fmi.cosim import program_start_warnings
    from m4e_fmi.simulate import started

    for line in program_start_warnings(system, started(program, start_values(options))):
        print(f"warning: {line}", file=sys.stderr)


def _simulate_to(
    output: Path, animation: Path | None, model: Model | Program, options: argparse.Namespace
) -> None:
    from m4e_fmi.program import Program
    from m4e_fmi.report import (
        animate,
        plot_simulation,
        progress_bar,
        simulation_summary,
        write_simulation,
    )
    from m4e_fmi.simulate import Watch, simulate

    events = [Watch(name) for name in options.event]
    events += [Watch(name, terminal=True) for name in options.stop_at]
    with progress_bar(options.stop_time) as progress:
        result = simulate(
            model,
            stop_time=options.stop_time,
            output_interval=options.output_interval,
            start_values=start_values(options),
            tolerance=options.tolerance,
            method=options.method,
            step_size=options.step_size,
            events=events,
            needed=options.variables,
            progress=progress,
        )
    files = write_simulation(result, output)
    print(simulation_summary(result))
    for name in () if isinstance(model, Program) else _unmoved(model, start_values(options)):
        print(f"  note: joint {name!r} starts where the parameters in the file put it")
    print_files(files)
    sys.stdout.flush()  # pictures take a second, within which a signal may end it
    if not options.no_plot:
        picture = output.with_suffix(".png")
        print_files([plot_simulation(result, picture, variables=options.variables)])
    if animation and not isinstance(model, Program):
        print_files([animate(model, result, animation)])


def _unmoved(model: Model, given: Iterable[str]) -> list[str]:
    """Joints whose start positions or velocities follow from parameters that are `given` anew."""
    from m4e_fmi.model.quantity import as_expression

    names = set(given)
    return [
        name
        for name, joint in model.joints.items()
        if any(names & as_expression(value).names() for value in joint.initial.values())
    ]


def _animation_file(options: argparse.Namespace, name: str) -> Path | None:
    """Path of the animation; None if none is wanted."""
    from m4e_fmi.report import check_animation_path

    if options.animate is None:
        return None
    default = output_file(options, name).with_suffix(".html")
    path = options.animate if options.animate.name else default
    check_animation_path(path)
    return path
