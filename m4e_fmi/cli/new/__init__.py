"""`m4e-fmi new` writes a working start: a model, a system, a study, a controller, an adapter.

Imports `cli/shared`. A template whose name ends in `.txt` is code that no check takes for ours.
"""

from __future__ import annotations

import argparse
import keyword
import re
import shlex
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path

from m4e_fmi.cli.shared.log import print_files
from m4e_fmi.errors import InputError, Problem

TEMPLATES = Path(__file__).parent / "templates"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


@dataclass(frozen=True)
class _Start:
    """Contents of a start: files by their templates, and the commands that come next.

    In paths and commands `NAME` stands for the name. `is_code` is true if the name becomes that of
    a Python module. Files `beside` are written where the first of them is not there yet.
    """

    text: str
    files: dict[str, str]
    commands: tuple[tuple[str, str], ...]
    is_code: bool = False
    beside: dict[str, str] = field(default_factory=dict)


_RUN = ("m4e-fmi run NAME.system.yaml", "simulate it; results and a picture go to build/")
_LOOK = ("m4e-fmi info NAME.system.yaml", "show all variables")
_SYSTEM = {"system.yaml": "NAME.system.yaml", "float.model.yaml": "NAME_float.model.yaml"}
KINDS = {
    "model": _Start(
        "a mechanism with parameters, joints and loads",
        {"model.yaml": "NAME.model.yaml"},
        (
            ("m4e-fmi simulate NAME.model.yaml --animate", "simulate it; an animation in build/"),
            ("m4e-fmi equations NAME.model.yaml", "show its equations of motion"),
            ("m4e-fmi build NAME.model.yaml", "make an FMU of it"),
        ),
    ),
    "system": _Start(
        "a float in irregular waves with a power take-off",
        _SYSTEM,
        (
            _RUN,
            ("m4e-fmi rao NAME.system.yaml", "its response to regular waves"),
            _LOOK,
        ),
    ),
    "study": _Start(
        "many runs of NAME.system.yaml, which is written if it is not there",
        {"study.yaml": "NAME.study.yaml"},
        (
            ("m4e-fmi study NAME.study.yaml", "make them; the result goes to build/"),
        ),
        beside=_SYSTEM,
    ),
    "controller": _Start(
        "a controller in one Python file, and a system that uses it",
        {
            "controller/controller.py.txt": "NAME.py",
            "controller/system.yaml": "NAME.system.yaml",
            "rail_float.model.yaml": "NAME_float.model.yaml",
        },
        (_RUN, _LOOK),
        is_code=True,
    ),
    "adapter": _Start(
        "a package with a kind of component of your own",
        {
            "adapter/pyproject.toml.txt": "NAME/pyproject.toml",
            "adapter/package.py.txt": "NAME/NAME/__init__.py",
            "adapter/physics.py.txt": "NAME/NAME/physics.py",
            "adapter/fmu.py.txt": "NAME/NAME/fmu.py",
            "adapter/test.py.txt": "NAME/tests/test_NAME.py",
            "adapter/system.yaml": "NAME/NAME.system.yaml",
            "rail_float.model.yaml": "NAME/NAME_float.model.yaml",
        },
        (
            ("cd NAME", ""),
            ("pip install -e .", "once: m4e-fmi then knows the kind"),
            _RUN,
            ("m4e-fmi validate build/NAME_try/damper.fmu", "check the FMU"),
        ),
        is_code=True,
    ),
}  # fmt: skip


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `new`."""
    kinds = "; ".join(f"{name}: {kind.text}" for name, kind in KINDS.items())
    command.add_argument("kind", choices=tuple(KINDS), help=kinds)
    command.add_argument("name", metavar="NAME", help="letters, digits and _, as my_buoy")
    command.add_argument(
        "--folder", type=Path, default=Path(), metavar="DIR", help="default: the current one"
    )
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    folder, name = options.folder, options.name
    kind = KINDS[options.kind]
    problems = [*_wrong_name(name, is_code=kind.is_code)]
    InputError.raise_for(problems)
    files = {
        template: folder / target.replace("NAME", name)
        for template, target in (kind.files | kind.beside).items()
    }
    if any(files[template].exists() for template in list(kind.beside)[:1]):
        files = {template: files[template] for template in kind.files}
    texts = {path: _filled(template, name) for template, path in files.items()}
    problems = [*_occupied(folder, texts)]
    InputError.raise_for(problems)
    for path, text in texts.items():
        _write(path, text)
    print_files(texts)
    print("next:")
    steps = [(command.replace("NAME", name), text) for command, text in kind.commands]
    if folder != Path():
        steps.insert(0, (f"cd {shlex.quote(str(folder))}", ""))
    width = max(len(command) for command, text in steps if text)
    for command, text in steps:
        print(f"  {command:<{width}}   # {text}" if text else f"  {command}")


def _filled(template: str, name: str) -> str:
    """The text of a template with the name in its places."""
    text = (TEMPLATES / template).read_text(encoding="utf-8")
    class_name = "".join(part[:1].upper() + part[1:] for part in name.split("_"))
    return text.replace("<<name>>", name).replace("<<Class>>", class_name)


def _wrong_name(name: str, *, is_code: bool) -> Iterator[Problem]:
    """Why `name` is no name for files and, if `is_code`, for a Python module."""
    from m4e_fmi.files.file_names import is_device

    if not _NAME.fullmatch(name):
        message = f"{name!r} is not a name: it takes a letter, then letters, digits and _"
        yield Problem(message, "take one such as my_buoy")
    elif is_device(name):
        yield Problem(f"{name} is the name of a device on Windows", f"take my_{name}")
    elif is_code and (keyword.iskeyword(name) or name in sys.stdlib_module_names):
        yield Problem(f"{name} is a word or a module of Python", f"take my_{name}")
    elif is_code and find_spec(name) is not None:
        yield Problem(f"a Python package {name} is installed already", f"take my_{name}")


def _occupied(folder: Path, texts: dict[Path, str]) -> Iterator[Problem]:
    """Files that are there already; or why they cannot be written into `folder`."""
    if folder.exists() and not folder.is_dir():
        yield Problem("is not a folder", "name another --folder", str(folder))
        return
    for path in texts:
        if path.exists() or path.is_symlink():
            remedy = "take another name or --folder: no file is overwritten"
            yield Problem("is there already", remedy, str(path))


def _write(path: Path, text: str) -> None:
    """Write a file that is not there yet; RunError if it cannot be written."""
    from m4e_fmi.files.writing import cannot_write

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except OSError as error:
        raise cannot_write(path, error) from error
