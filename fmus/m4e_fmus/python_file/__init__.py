"""The FMU of `kind: python`: a force or a controller in one Python file of the user.

`KIND.build` reads the class of that file (`user_class`, `declarations`), records it as a Program if
it can (`recorded`), and else packs it as Python code (`slave`). README.md says what a file
contains.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType

from m4e_fmi.code_hash import OWN
from m4e_fmi.errors import InputError, Problem, is_file, missing_file
from m4e_fmi.files.document import Section
from m4e_fmi.files.files_read import read_text
from m4e_fmi.fmu import FmuKind, FmuVariable, ModelDescription, PythonSource
from m4e_fmi.program import Program
from m4e_fmus.python_file.declarations import Lines, Variables, declared
from m4e_fmus.python_file.recorded import CannotBeRecordedError, recorded
from m4e_fmus.python_file.user_class import UserClass, UserCodeError, loaded

HERE = Path(__file__).parent
TRAVELS = ("slave.py", "user_class.py", "saved_values.py")


class Config(Section):
    """A component in one Python `file`, with a class that declares variables and computes.

    `files` are others that it reads or imports, which travel beside it in the FMU. Both are
    relative to the system file's folder. The file is run when the system is read.
    """

    file: str
    files: tuple[str, ...] = ()


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
    places, hidden = list(sys.path), dict[str, ModuleType]()
    # as in the FMU: what is not there is not found here either, also in the current folder
    with TemporaryDirectory() as alone:
        for file in (path, *others):
            shutil.copy(file, alone)
        sys.path[:] = [place for place in places if Path(place).resolve() != path.parent]
        try:
            hidden = {key: sys.modules.pop(key) for key in _imported_from(path.parent)}
            return _made(Path(alone) / path.name, path, others, name=name, progress=progress)
        finally:
            sys.modules.update(hidden)
            sys.path[:] = places


def _imported_from(folder: Path) -> list[str]:
    """The imported modules of a folder, and of packages in it, but for this package's own."""
    beside = {path.stem for path in folder.iterdir()} - {*OWN}
    found = {
        key.partition(".")[0]
        for key, module in sys.modules.items()
        if key.partition(".")[0] in beside
        and Path(getattr(module, "__file__", None) or "").resolve().is_relative_to(folder)
    }
    return [key for key in sys.modules if key.partition(".")[0] in found]


def _made(
    copy: Path, path: Path, others: list[Path], *, name: str, progress: Callable[[str], None]
) -> Program | PythonSource:
    """The component of a `copy` of the file at `path`, with `others` beside it."""
    shown = path.name
    try:
        source = read_text(path)
        module = loaded(copy, shown, f"checked_{path.stem}")
        user = UserClass(module, copy, shown)
    except UnicodeDecodeError:
        raise InputError.single("is not text in UTF-8", "save it so", str(path)) from None
    except UserCodeError as error:
        place, _, text = str(error).removeprefix(f"{shown}:").partition(": ")
        if place.isdigit():
            raise InputError([Problem(text, "", str(path), int(place))]) from None
        raise InputError.single(str(error).removeprefix(f"{shown}: "), "", str(path)) from None
    lines = Lines(source)
    variables = declared(user, path, lines)
    for method in ("rates", "calculate"):
        line, attribute = lines.of_changes(method)
        if line:
            progress(
                f"warning: {shown}:{line}: {method} sets self.{attribute}, but it is called any "
                "number of times in a step, also with values that are only tried: set it in start "
                "or step"
            )
    if others:
        progress(f"{shown} stays Python code: it has other files beside it")
        return _python_source(user, path, others, name=name, variables=variables, lines=lines)
    try:
        program = recorded(copy, shown, name=name, variables=variables, lines=lines)
    except CannotBeRecordedError as error:
        progress(f"{shown} stays Python code, it cannot be recorded: {error}")
        return _python_source(user, path, others, name=name, variables=variables, lines=lines)
    progress(f"{shown} is recorded as a program")
    return program


def _there(folder: Path, file: str, keys: tuple[str | int, ...]) -> Path:
    path = (folder / file).resolve()
    if not is_file(path):
        raise InputError.single(*missing_file(path), keys=keys)
    if not path.is_relative_to(folder.resolve()):
        text, remedy = f"{file} is outside of the system's folder", "copy it there"
        raise InputError.single(text, remedy, keys=keys)
    return path


def _python_source(
    user: UserClass,
    path: Path,
    others: list[Path],
    *,
    name: str,
    variables: Variables,
    lines: Lines,
) -> PythonSource:
    data = {
        "file": path.name,
        "variables": {g: [asdict(v) for v in own.values()] for g, own in variables.items()},
        "holds": not user.has("calculate"),
    }
    text = user.kind.__doc__ or f"{user.kind.__name__} of {path.name}"
    described = _described(variables, user, lines, path.name)
    return PythonSource(
        description=ModelDescription(name, text.strip(), tuple(described)),
        slave="slave:PythonFileSlave",
        modules={file: HERE / file for file in TRAVELS},
        data={
            "component.json": json.dumps(data).encode(),
            **{f"user/{file.name}": file.read_bytes() for file in (path, *others)},
        },
    )


def _described(
    variables: Variables, user: UserClass, lines: Lines, shown: str
) -> Iterator[FmuVariable]:
    """The variables of the FMU, with the place in the file where an output comes from.

    What outputs depend on is not known: calculated ones on everything, held ones on nothing now.
    Those of code with steps of its own are discrete: they change where it is sampled.
    """
    variability = "discrete" if user.has("step") else "continuous"
    held = not user.has("calculate")  # outputs are those that the last step has returned
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
    method = user.line("step" if held else "calculate")
    for v in variables["outputs"].values():
        text = v.made_at(f"{shown}:{lines.of(v.name, after=method)}")
        for element in v.elements:
            yield FmuVariable(
                element, v.unit, text,
                causality="output", variability=variability, initial="calculated",
                dependencies=() if held else None, initial_dependencies=None,
            )  # fmt: skip


KIND = FmuKind(Config, build=_build)
