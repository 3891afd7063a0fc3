"""`m4e-fmi simulate` simulates one model, or a system as one program, in this process."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cli.shared.log import (
    add_log,
    detail,
    note,
    print_files,
    progress,
    show,
    tell_event,
    warn,
)
from m4e_fmi.cli.shared.options import (
    MODEL_OR_SYSTEM,
    add_options,
    animation_file,
    is_system,
    load_only_model,
    load_program,
    load_system,
    output_file,
    report_file,
    start_values,
)
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.signals import Terminated

if TYPE_CHECKING:
    from m4e_fmi.model import Model
    from m4e_fmi.program import Program
    from m4e_fmi.report.animation.scene import Scene
    from m4e_fmi.report.run_report.record import InputFile
    from m4e_fmi.simulate import Simulation


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `simulate`."""
    command.add_argument(
        "model", type=Path, help=f"{MODEL_OR_SYSTEM}; or an FMU, with the options of run"
    )
    add_options(command, "--open", "--settled", "--build-folder")
    for flag, text in (("--stop-time", "10 s"), ("--output-interval", "0.01 s")):
        command.add_argument(
            flag, type=float, metavar="S", help=f"default {text}; of a system as in its file"
        )
    command.add_argument("--tolerance", type=float, default=1e-8, help="default 1e-8")
    command.add_argument(
        "--method",
        default="dop853",
        help="dop853 (default), rk45, rodas (stiff) or rk4 (fixed steps)",
    )
    command.add_argument(
        "--step-size", type=float, metavar="S", help="of rk4, at most; default the output interval"
    )
    for flag, text in (
        ("--event", "report sign changes of this output or state, as load.STOP.gap at contact"),
        ("--stop-at", "end when this output or state changes sign"),
    ):
        command.add_argument(flag, action="append", default=[], metavar="NAME", help=text)
    add_options(command, "--start-value", "--output-file")
    add_options(command, "--animate", "--report", "--no-plot")
    command.add_argument(
        "--variables",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME",
        help="variables in the picture; default the main ones",
    )
    add_log(command, events=True)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.files.locks import claimed
    from m4e_fmi.program import Program
    from m4e_fmi.results.results_file import stream_of

    source = _source(options)
    output = output_file(options, source.name)
    whole = isinstance(source.equations, Program)
    animation = animation_file(options, source.name)
    if animation and whole and source.scene is None:
        raise InputError.single(f"{source.name} shows no bodies", "leave out --animate")
    report_file(options, output)
    with claimed(stream_of(output)):  # and the pictures
        _simulate_to(output, animation, source, options)


@dataclass(frozen=True)
class _Source:
    """A model, or the program of a system and its `scene`; the `name` of the results.

    `inputs` are the files that it is made of.
    """

    equations: Model | Program
    name: str
    scene: Scene | None
    inputs: tuple[InputFile, ...]

    def scene_of(self, simulation: Simulation) -> Scene | None:
        """The scene of the results; a model has the lengths that were simulated."""
        from m4e_fmi.files.file_names import file_stem
        from m4e_fmi.program import Program
        from m4e_fmi.report.animation.of_model import scene_of_simulation

        if isinstance(self.equations, Program):
            return self.scene
        return scene_of_simulation(self.equations, simulation, file_stem(self.equations.name))


def _source(options: argparse.Namespace) -> _Source:
    """The model, or the program of the system.

    Times that are not given become those of the system, or the default.
    """
    from m4e_fmi.report.run_report.record import input_file

    stop_time, interval = 10.0, 0.01
    if is_system(options.model):
        from m4e_fmi.cosim import scene_without_build
        from m4e_fmi.cosim.results.run_record import system_inputs

        system = load_system(options.model)
        times = system.simulation
        if times.start_time:
            message = f"start_time is {times.start_time:g} s: a program starts at 0"
            raise InputError([system.problem(("simulation", "start_time"), message, "set it to 0")])
        stop_time, interval = times.stop_time, times.output_interval or times.step_size
        program = load_program(system, options)
        given = start_values(options)
        names = {component.name for component in system.components}
        own = {name: value for name, value in given.items() if name.partition(".")[0] in names}
        scene = scene_without_build(system.changed(start=own, origin="command line"))
        found = _Source(program, f"{system.name}_whole", scene, system_inputs(system))
        if system.scenario:
            warn("warning: the scenario takes no part: one program has no actions")
    else:
        model = load_only_model(options)
        read = input_file(options.model, options.model.name)
        found = _Source(model, model.name, None, (read,) if read else ())
    if options.stop_time is None:
        options.stop_time = stop_time
    if options.output_interval is None:
        options.output_interval = interval
    return found


def _simulate_to(
    output: Path, animation: Path | None, source: _Source, options: argparse.Namespace
) -> None:
    from m4e_fmi.program import Program
    from m4e_fmi.report import (
        simulation_numbers,
        simulation_summary,
        simulation_text,
        write_simulation,
    )
    from m4e_fmi.results.results_file import load_results
    from m4e_fmi.simulate.limits import limits_left
    from m4e_fmi.simulate.simulation import FIXED

    fixed = options.method == FIXED
    tell_event(
        "plan",
        name=source.name,
        method=options.method,
        start_time=0.0,
        stop_time=options.stop_time,
        step_size=(options.step_size or options.output_interval) if fixed else 0.0,
        output_interval=options.output_interval,
        components=[],
        results=str(output),
    )
    result = _simulated(output, source, options)
    for line in limits_left(result):
        warn(f"warning: {line}")
    files = write_simulation(result, output, scene=source.scene_of(result), inputs=source.inputs)
    numbers, variables = simulation_numbers(result)
    text, summary = simulation_text(result, load_results(files[0])), simulation_summary(result)
    show(text, "summary", numbers=numbers, variables=variables)
    model = source.equations
    for name in () if isinstance(model, Program) else _unmoved(model, start_values(options)):
        note(f"note: joint {name!r} starts where the parameters in the file put it")
    detail(summary)
    sys.stdout.flush()  # pictures take a second, within which a signal may end it
    try:
        files += _pictures(result, files[0], output, animation, source, options)
        if report := report_file(options, output):
            from m4e_fmi.report import report_of_run

            files += [report_of_run(files[0], report, command=options.given)]
    finally:
        print_files(files)


def _simulated(output: Path, source: _Source, options: argparse.Namespace) -> Simulation:
    """The simulation; errors and signals that end it early tell where its rows are kept."""
    from m4e_fmi.simulate import SimulationError, Watch, simulate

    events = [Watch(name) for name in options.event]
    events += [Watch(name, terminal=True) for name in options.stop_at]
    left: list[Simulation] = []
    try:
        with progress(options.stop_time) as moving:
            return simulate(
                source.equations,
                stop_time=options.stop_time,
                output_interval=options.output_interval,
                start_values=start_values(options),
                tolerance=options.tolerance,
                method=options.method,
                step_size=options.step_size,
                events=events,
                needed=options.variables,
                progress=moving,
                interrupted=left.append,
            )
    except SimulationError as error:
        kept = _write_partial(error.simulation, f"failed: {error.message}", output, source, options)
        raise RunError(error.message, f"{error.remedy}; {kept}".strip("; ")) from error
    except (KeyboardInterrupt, Terminated) as error:
        ended = str(error) or "interrupted"
        for simulation in left:
            error.add_note(_write_partial(simulation, ended, output, source, options))
        raise


def _pictures(
    result: Simulation,
    file: Path,
    output: Path,
    animation: Path | None,
    source: _Source,
    options: argparse.Namespace,
) -> Iterator[Path]:
    """Draw and animate the results in `file`, as far as asked for."""
    from m4e_fmi.program import Program

    if not options.no_plot:
        from m4e_fmi.report import plot_simulation

        picture = output.with_suffix(".png")
        yield plot_simulation(result, picture, variables=options.variables)
    if animation:
        from m4e_fmi.report import animate, animate_run

        model = source.equations
        whole = isinstance(model, Program)
        yield animate_run(file, animation) if whole else animate(model, result, animation)


def _write_partial(
    simulation: Simulation, ended: str, output: Path, source: _Source, options: argparse.Namespace
) -> str:
    """The place of the rows of a simulation that `ended` early, which are written here.

    A single row replaces no earlier results.
    """
    from m4e_fmi.report import write_simulation
    from m4e_fmi.results.results_file import stream_of

    rows = len(simulation.time)
    if rows == 1 and stream_of(output).is_file():
        return f"the simulation made no step: {output} is as it was"
    count = f"{rows:,} row{'s' * (rows != 1)}"
    try:
        files = write_simulation(
            simulation, output, scene=source.scene_of(simulation), inputs=source.inputs, ended=ended
        )
    except RunError as error:
        return f"its {count}: {error}"
    picture = None if options.no_plot else output.with_suffix(".png")
    beside = picture, animation_file(options, source.name), report_file(options, output)
    for earlier in filter(None, beside):
        earlier.unlink(missing_ok=True)
    return f"results until t = {simulation.time[-1]:.9g} s are in {files[-1]} ({count})"


def _unmoved(model: Model, given: Iterable[str]) -> list[str]:
    """Joints whose start positions or velocities follow from parameters that are `given` anew."""
    from m4e_fmi.model.quantity import as_expression

    names = set(given)
    return [
        name
        for name, joint in model.joints.items()
        if any(names & as_expression(value).names() for value in joint.initial.values())
    ]
