"""The command `m4e-fmi`. Exit codes: 0 done, 1 the work failed, 2 wrong input or usage."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path

import m4e_fmi
from m4e_fmi.errors import InputError, M4eError, RunError

EXIT_FAILED = 1
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130
BUILD_FOLDER = "build"
MODEL_FILE = "a model: ours, Chrono's or the paper's lists (YAML)"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = _parser().parse_args(arguments)
    try:
        return options.command(options) or 0
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return EXIT_USAGE
    except RunError as error:
        print(f"failed: {error}", file=sys.stderr)
        return EXIT_FAILED
    except M4eError as error:
        print(f"error: {error}", file=sys.stderr)
        return EXIT_FAILED
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()  # the reader of our output has left: nothing to tell it
        return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="m4e-fmi",
        description="Multibody equations of motion, FMUs of them, and coupled simulation.",
        epilog="Each command has its own --help.",
    )
    parser.add_argument("--version", action="version", version=f"m4e_fmi {m4e_fmi.__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    _add_equations(commands)
    _add_draw(commands)
    _add_simulate(commands)
    _add_linearize(commands)
    _add_build(commands)
    _add_info(commands)
    _add_validate(commands)
    _add_run(commands)
    _add_doctor(commands)
    return parser


def _add_equations(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("equations", help="print a model's equations of motion")
    command.add_argument("model", type=Path, help=MODEL_FILE)
    form = command.add_mutually_exclusive_group()
    form.add_argument("--latex", action="store_true", help="as LaTeX instead of text")
    form.add_argument(
        "--code", choices=("python", "c"), help="M and f as source of a function instead"
    )
    command.add_argument(
        "--explicit",
        action="store_true",
        help="write out in full what a long page computes once, on a line of its own",
    )
    command.add_argument("--reactions", action="store_true", help="also what each joint carries")
    command.set_defaults(command=_equations)


def _equations(options: argparse.Namespace) -> None:
    from m4e_fmi.model import load_model
    from m4e_fmi.multibody import Equations

    equations = Equations(load_model(options.model))
    if options.code:
        print(equations.code(options.code), end="")
        return
    explicit = options.explicit or None
    print(equations.text(latex=options.latex, reactions=options.reactions, explicit=explicit))


def _add_draw(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("draw", help="draw a model in its start pose")
    command.add_argument("model", type=Path, help=MODEL_FILE)
    command.add_argument(
        "--output-file",
        type=Path,
        metavar="FILE",
        help=".png, .svg or .pdf; default build/NAME_model.png",
    )
    command.set_defaults(command=_draw)


def _draw(options: argparse.Namespace) -> None:
    from m4e_fmi.model import load_model
    from m4e_fmi.report import draw_model

    model = load_model(options.model)
    picture = options.output_file or Path(BUILD_FOLDER) / f"{model.name}_model.png"
    _print_files([draw_model(model, picture)])


def _add_simulate(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("simulate", help="simulate one model in this process")
    command.add_argument("model", type=Path, help=MODEL_FILE)
    command.add_argument("--stop-time", type=float, default=10.0, metavar="S", help="default 10 s")
    command.add_argument(
        "--output-interval", type=float, default=0.01, metavar="S", help="default 0.01 s"
    )
    command.add_argument("--tolerance", type=float, default=1e-8, help="default 1e-8")
    command.add_argument(
        "--method",
        default="dop853",
        help="dop853 (default), rk45, rodas (stiff), python, or SciPy's, as scipy.RK45",
    )
    for flag, text in (
        ("--event", "tell when this output or state changes sign, as load.STOP.gap at contact"),
        ("--stop-at", "end when this output or state changes sign"),
    ):
        command.add_argument(flag, action="append", default=[], metavar="NAME", help=text)
    _add_start_values(command, "NAME")
    _add_output_file(command)
    command.add_argument(
        "--animate",
        nargs="?",
        type=Path,
        const=Path(),
        metavar="FILE",
        help="write an animation (.html or .gif); default build/NAME.html",
    )
    command.add_argument("--no-plot", action="store_true", help="no picture beside the results")
    command.set_defaults(command=_simulate)


def _simulate(options: argparse.Namespace) -> None:
    from m4e_fmi.model import load_model
    from m4e_fmi.report import (
        animate,
        plot_simulation,
        progress_bar,
        simulation_summary,
        write_simulation,
    )
    from m4e_fmi.simulate import Watch, simulate

    model = load_model(options.model)
    animation = _animation_file(options, model.name)
    events = [Watch(name) for name in options.event]
    events += [Watch(name, terminal=True) for name in options.stop_at]
    with progress_bar(options.stop_time) as progress:
        result = simulate(
            model,
            stop_time=options.stop_time,
            output_interval=options.output_interval,
            start_values=_start_values(options),
            tolerance=options.tolerance,
            method=options.method,
            events=events,
            progress=progress,
        )
    files = [_output_file(options, model.name)]
    write_simulation(result, files[0])
    if not options.no_plot:
        files.append(plot_simulation(result, files[0].with_suffix(".png")))
    if animation:
        files.append(animate(model, result, animation))
    print(simulation_summary(result))
    _print_files(files)


def _animation_file(options: argparse.Namespace, name: str) -> Path | None:
    """Where the animation goes; None if none is wanted."""
    from m4e_fmi.report import check_animation_path

    if options.animate is None:
        return None
    default = _output_file(options, name).with_suffix(".html")
    path = options.animate if options.animate.name else default
    check_animation_path(path)
    return path


def _add_linearize(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser(
        "linearize", help="equilibrium, frequencies and damping, state space of a model"
    )
    command.add_argument("model", type=Path, help=MODEL_FILE)
    command.add_argument(
        "--at",
        choices=tuple(POINTS),
        default="equilibrium",
        help="where it settles from the start values (default), the equilibrium that is nearest "
        "to them, stable or not, or these values themselves",
    )
    command.add_argument("--time", type=float, default=0.0, metavar="S", help="default 0 s")
    for flag, text in (
        ("--inputs", "inputs or parameters of B and D; default none"),
        ("--outputs", "outputs or states of C and D; default all states"),
    ):
        command.add_argument(flag, nargs="+", metavar="NAME", help=text)
    _add_start_values(command, "NAME")
    command.add_argument("--json", action="store_true", help="print everything as JSON")
    command.add_argument(
        "--output-file", type=Path, metavar="FILE", help="write A, B, C, D, M, C, K here (JSON)"
    )
    command.set_defaults(command=_linearize)


POINTS = {
    "equilibrium": "equilibrium",
    "nearest": "nearest equilibrium",
    "start": "start values",
}


def _linearize(options: argparse.Namespace) -> None:
    import json

    from m4e_fmi.analysis import equilibrium, linearize, modes
    from m4e_fmi.model import load_model
    from m4e_fmi.report import linear_json, linear_text

    model, at = load_model(options.model), _start_values(options)
    if options.at != "start":
        at = equilibrium(model, at=at, time=options.time, nearest=options.at == "nearest")
    linear = linearize(
        model, at=at, time=options.time, inputs=options.inputs or (), outputs=options.outputs
    )
    found = modes(linear)
    if options.json:
        print(json.dumps(linear_json(linear, found), indent=2))
    else:
        print(linear_text(linear, found, title=POINTS[options.at]))
    if options.output_file:
        options.output_file.parent.mkdir(parents=True, exist_ok=True)
        text = json.dumps(linear_json(linear, found), indent=2)
        options.output_file.write_text(text + "\n", encoding="utf-8")
        if not options.json:
            _print_files([options.output_file])


def _add_build(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("build", help="build the FMU of a model, or all of a system")
    command.add_argument("source", type=Path, help="a model or system file")
    command.add_argument(
        "--native", action="store_true", help="of a model: no Python inside, model exchange too"
    )
    command.add_argument(
        "--sources", action="store_true", help="with --native: C sources too, for other platforms"
    )
    _add_build_folder(command)
    command.set_defaults(command=_build)


def _build(options: argparse.Namespace) -> None:
    from m4e_fmi.fmu import build_fmu

    if _is_system(options.source):
        from m4e_fmi.cosim import System, fmu_files

        if options.native:
            raise InputError.single("--native builds the FMU of a model, not those of a system")
        files = fmu_files(System.load(options.source), options.build_folder, tell=_say)
        for name, path in files.items():
            print(f"{name}: {path}")
        return
    from m4e_fmi.multibody import model_program

    program = model_program(options.source)
    path = options.build_folder / f"{program.name}.fmu"
    _print_files([build_fmu(program, path, native=options.native, sources=options.sources)])


def _add_info(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("info", help="show what is in a model, a system or an FMU")
    command.add_argument("source", type=Path, help="a model, system or .fmu file")
    command.add_argument("--latex", action="store_true", help="a model's tables, in LaTeX")
    _add_build_folder(command)
    command.set_defaults(command=_info)


def _info(options: argparse.Namespace) -> None:
    from m4e_fmi.report import fmu_text

    if options.source.suffix == ".fmu":
        print(fmu_text(options.source))
    elif _is_system(options.source):
        from m4e_fmi.cosim import System, prepare

        system = System.load(options.source)
        print(prepare(system, build_directory=options.build_folder, tell=_say))
    else:
        from m4e_fmi.model import load_model
        from m4e_fmi.multibody import model_program
        from m4e_fmi.report import model_tables

        model = load_model(options.source)
        print(model_tables(model, latex=options.latex))
        if not options.latex:
            print(f"\n{model_program(model)}")


def _add_validate(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("validate", help="check FMUs: archive, description, first steps")
    command.add_argument("fmus", type=Path, nargs="+", metavar="FMU")
    command.add_argument("--json", action="store_true", help="print findings as JSON")
    command.set_defaults(command=_validate)


def _validate(options: argparse.Namespace) -> int:
    import json

    from m4e_fmi.cosim import check_fmu

    found = {str(path): check_fmu(path) for path in options.fmus}
    if options.json:
        print(json.dumps(found, indent=2))
    else:
        for path, findings in found.items():
            print(f"{path}: {'no finding' if not findings else f'{len(findings)} findings'}")
            for finding in findings:
                print(f"  {finding}")
    return EXIT_FAILED if any(found.values()) else 0


def _add_run(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("run", help="co-simulate a system of FMUs")
    command.add_argument("system", type=Path, help="a system file (YAML)")
    for flag, text in (
        ("--stop-time", "end of the run"),
        ("--step-size", "time between communication points"),
        ("--output-interval", "time between rows of the results"),
    ):
        command.add_argument(flag, type=float, metavar="S", help=f"{text}; default: as in the file")
    command.add_argument(
        "--algorithm", help="gauss_seidel, corrector, implicit or jacobi; default: as in the file"
    )
    command.add_argument(
        "--check",
        action="store_true",
        help="run once more at half the step, and tell how large the coupling errors are",
    )
    _add_start_values(command, "COMPONENT.VARIABLE")
    _add_output_file(command)
    _add_build_folder(command)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.cosim import System, prepare, run
    from m4e_fmi.report import plot_run, progress_bar, run_summary

    system = System.load(options.system).changed(
        start=_start_values(options),
        stop_time=options.stop_time,
        step_size=options.step_size,
        output_interval=options.output_interval,
        algorithm=options.algorithm,
    )
    output = _output_file(options, system.name)
    prepared = prepare(system, build_directory=options.build_folder, tell=_say)
    count, links = len(system.components), len(prepared.wiring.links)
    print(f"{system.name}: {count} FMUs, {links} connected variables", flush=True)
    times = system.simulation
    with progress_bar(times.stop_time, start=times.start_time) as progress:
        outcome = run(prepared, results=output, progress=progress, check=options.check)
    picture = plot_run(output, output.with_suffix(".png"))
    print(run_summary(outcome))
    _print_files([output, picture])


def _add_doctor(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("doctor", help="what is installed here, and what is missing")
    command.add_argument("--json", action="store_true", help="print findings as JSON")
    command.set_defaults(command=_doctor)


def _doctor(options: argparse.Namespace) -> int:
    import json

    from m4e_fmi import doctor

    findings = doctor.examine()
    print(
        json.dumps(doctor.as_json(findings), indent=2) if options.json else doctor.report(findings)
    )
    return EXIT_FAILED if any(f.needed and not f.ok for f in findings) else 0


def _add_start_values(command: argparse.ArgumentParser, name: str) -> None:
    command.add_argument(
        "--start-value",
        nargs=2,
        action="append",
        default=[],
        metavar=(name, "VALUE"),
        help="set a parameter, input or state at the start; may be given again",
    )


def _add_output_file(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--output-file", type=Path, metavar="FILE", help="results (.nc); default build/NAME.nc"
    )


def _add_build_folder(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--build-folder",
        type=Path,
        default=Path(BUILD_FOLDER),
        metavar="DIR",
        help="default build/",
    )


def _start_values(options: argparse.Namespace) -> dict[str, float]:
    values = {}
    for name, text in options.start_value:
        try:
            values[name] = float(text)
        except ValueError:
            message = f"--start-value {name} {text}: {text!r} is not a number"
            raise InputError.single(message) from None
    return values


def _output_file(options: argparse.Namespace, name: str) -> Path:
    return options.output_file or Path(BUILD_FOLDER) / f"{name}.nc"


def _is_system(path: Path) -> bool:
    """Whether a YAML file describes a system rather than a model."""
    from m4e_fmi.document import Document

    return "components" in Document.load(path).data


def _say(text: str) -> None:
    """Print a line; one that counts ("… 3 of 40") overwrites itself on a terminal."""
    counting = re.search(r"(\d+) of (\d+)$", text)
    if counting and sys.stdout.isatty():
        last = counting[1] == counting[2]
        print(f"\r\033[K{text}", end="\n" if last else "", flush=True)
    elif not counting or int(counting[1]) % 10 == 0:
        print(text, flush=True)


def _print_files(paths: object) -> None:
    for path in paths:  # type: ignore[attr-defined]
        print(f"wrote {path}")


if __name__ == "__main__":
    sys.exit(main())
