"""The FMU of `kind: python`: a force or a controller in one Python file of the user.

`KIND.build` reads the class of that file (`user_class`, `declarations`), records it as a Program if
it can (`recorded`), and else packs it as Python code (`slave`). README.md says what a file
contains.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path

from m4e_fmi.errors import InputError, Problem, is_file, missing_file
from m4e_fmi.files.files_read import read_text
from m4e_fmi.fmu import FmuKind, FmuVariable, ModelDescription, PythonSource
from m4e_fmi.program import Program
from m4e_fmus.python_file.config import Config
from m4e_fmus.python_file.declarations import Lines, Variables, declared, ends_of_process
from m4e_fmus.python_file.recorded import recorded
from m4e_fmus.python_file.recording_file import CannotBeRecordedError
from m4e_fmus.python_file.user_class import UserClass, UserCodeError, loaded

HERE = Path(__file__).parent
TRAVELS = ("slave.py", "user_class.py", "saved_values.py")


def _build(
    config: Config, *, name: str, folder: Path, progress: Callable[[str], None] = print
) -> Program | PythonSource:
    """The component called `name`: a Program if its arithmetic can be recorded.

    InputError with file and line for what is wrong with the file.
    """
    path = _there(folder, config.file, ("file",))
    if path.suffix != ".py":
        text = f"{config.file} is no Python file"
        raise InputError.single(text, "name a file that ends in .py", keys=("file",))
    others = [_there(folder, file, ("files", k)) for k, file in enumerate(config.files)]
    names = [file.name for file in (path, *others)]
    for k, name_of in enumerate(names[1:], 1):
        if name_of in names[:k]:
            text = f"two files are called {name_of}: they travel in one folder"
            raise InputError.single(text, "rename one of them", keys=("files", k - 1))
    shown, lines = path.name, Lines(_source(path))
    _check_ends([path, *(file for file in others if file.suffix == ".py")])
    try:
        user = UserClass(loaded(path, shown, f"checked_{path.stem}", travels=names), path, shown)
    except UserCodeError as error:
        raise _input_error(str(error), path) from None
    variables = declared(user, path, lines)
    for method in ("rates", "calculate"):
        line, attribute = lines.of_changes(user.kind.__name__, method)
        if line:
            progress(
                f"warning: {shown}:{line}: {method} sets self.{attribute}, but it is called any "
                "number of times in a step, also with values that are only tried: set it in start "
                "or step"
            )
    if not others:
        try:
            program = recorded(path, shown, name=name, variables=variables, lines=lines)
        except CannotBeRecordedError as error:
            progress(f"{shown} stays Python code, it cannot be recorded: {error}")
        else:
            progress(f"{shown} is recorded as a program")
            return program
    else:
        progress(f"{shown} stays Python code: it has other files beside it")
    return _python_source(user, path, others, name=name, variables=variables, lines=lines)


def _there(folder: Path, file: str, keys: tuple[str | int, ...]) -> Path:
    path = (folder / file).resolve()
    if not is_file(path):
        raise InputError.single(*missing_file(path), keys=keys)
    if not path.is_relative_to(folder.resolve()):
        text, remedy = f"{file} is outside of the system's folder", "copy it there"
        raise InputError.single(text, remedy, keys=keys)
    return path


def _source(path: Path) -> str:
    try:
        return read_text(path)
    except UnicodeDecodeError:
        raise InputError.single("is not text in UTF-8", "save it so", str(path)) from None


def _check_ends(paths: list[Path]) -> None:
    """InputError if a file calls what ends the process: nothing of it may have run before."""
    problems = [
        Problem(
            f"os.{name} ends the whole run without an error",
            "raise an error: it is told with its line, and the rows up to there are kept",
            str(path),
            line,
        )
        for path in paths
        for line, name in ends_of_process(_source(path))
    ]
    InputError.raise_for(problems)


def _input_error(text: str, path: Path) -> InputError:
    """The error of the text "file:line: message"."""
    place, _, rest = text.removeprefix(f"{path.name}:").partition(": ")
    if place.isdigit():
        return InputError([Problem(rest, "", str(path), int(place))])
    return InputError.single(text.removeprefix(f"{path.name}: "), "", str(path))


def _python_source(
    user: UserClass,
    path: Path,
    others: list[Path],
    *,
    name: str,
    variables: Variables,
    lines: Lines,
) -> PythonSource:
    held, calculated = _divided(user, variables)
    data = {
        "file": path.name,
        "shown": path.name,
        "variables": {g: [asdict(v) for v in own.values()] for g, own in variables.items()},
        "held": held,
        "calculated": calculated,
    }
    text = user.kind.__doc__ or f"{user.kind.__name__} of {path.name}"
    described = _described(variables, held, user, lines, path.name)
    return PythonSource(
        description=ModelDescription(name, text.strip(), tuple(described)),
        slave="slave:PythonFileSlave",
        modules={file: HERE / file for file in TRAVELS},
        data={
            "component.json": json.dumps(data).encode(),
            **{f"user/{file.name}": file.read_bytes() for file in (path, *others)},
        },
    )


def _divided(user: UserClass, variables: Variables) -> tuple[list[str], list[str]]:
    """Outputs that a step returns and holds, and those that `calculate` does whenever it is asked.

    All are of one sort: `calculate` has them if it is there.
    """
    names = list(variables["outputs"])
    return ([], names) if user.has("calculate") else (names, [])


def _described(
    variables: Variables, held: list[str], user: UserClass, lines: Lines, shown: str
) -> Iterator[FmuVariable]:
    """The variables of the FMU, with the place in the file where an output comes from.

    What outputs depend on is not known: calculated ones on everything, held ones on nothing now.
    Those of code with steps of its own are discrete: they change where it is sampled.
    """
    variability = "discrete" if user.has("step") else "continuous"
    for v in variables["parameters"].values():
        for element in v.elements:
            yield FmuVariable(
                element, v.unit, v.text,
                causality="parameter", variability="tunable", initial="exact", start=v.start,
            )  # fmt: skip
    for v in variables["inputs"].values():
        for element in v.elements:
            yield FmuVariable(element, v.unit, v.text, causality="input", start=v.start)
    for v in variables["states"].values():
        for element in v.elements:
            yield FmuVariable(
                element, v.unit, v.text, causality="output", initial="exact", start=v.start
            )
    for v in variables["outputs"].values():
        method = user.line("step" if v.name in held else "calculate")
        text = v.made_at(f"{shown}:{lines.of_result(v.name, method)}")
        for element in v.elements:
            yield FmuVariable(
                element, v.unit, text,
                causality="output", variability=variability, initial="calculated",
                dependencies=() if v.name in held else None, initial_dependencies=None,
            )  # fmt: skip


KIND = FmuKind(Config, build=_build)
