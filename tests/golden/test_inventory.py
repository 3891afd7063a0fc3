"""Everything that users can write or read, by name: inventory.txt.

Keys of files, options of commands, public names, kinds of FMU, variables of the examples' FMUs, and
the keys of what is printed or written for programs. `pytest --update` writes it anew: nothing
leaves the product, or comes in, without being seen in the difference.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import json
import math
import re
from collections.abc import Iterator
from contextlib import chdir
from enum import Enum
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from pydantic import BaseModel
from support.defects import planted
from support.example_systems import EXAMPLES

from m4e_fmi.cli import COMMANDS, main
from m4e_fmi.cli.shared.log import EVENTS
from m4e_fmi.cosim import load_system
from m4e_fmi.cosim.preparation.components import expected_descriptions
from m4e_fmi.cosim.system.component import kind_of, kinds
from m4e_fmi.cosim.system_file import _FileSection, _ParameterSection, _SystemSection
from m4e_fmi.files.sections import fields_of
from m4e_fmi.model.chrono.sections import ModelFileSection
from m4e_fmi.model.yaml import ModelSection
from m4e_fmi.results.results_file import load
from m4e_fmi.study.given.sections import StudySection

ROOT = Path(__file__).parents[2]
GOLDEN = Path(__file__).with_name("inventory.txt")
NUMBER = re.compile(r"\d+")
SYSTEMS = ("arm", "flexible_pendulum", "moored_buoy", "oc3_hywind", "sphere_decay", "two_flaps")
FILES: dict[str, type[BaseModel]] = {
    "model": ModelSection,
    "system": _SystemSection,
    "component": _FileSection,
    "parameters": _ParameterSection,
    "study": StudySection,
    "chrono": ModelFileSection,
}


def keys(section: type[BaseModel], above: tuple[type[BaseModel], ...] = ()) -> Iterator[str]:
    """Paths of all keys of a section; `*` stands for a name, `[]` for an entry of a list."""
    for key, field in fields_of(section).items():
        yield key
        for way, below in sections(field.annotation):
            if below not in (*above, section):
                yield from (f"{key}{way}.{path}" for path in keys(below, (*above, section)))


def sections(annotation: Any, way: str = "") -> Iterator[tuple[str, type[BaseModel]]]:
    """The sections that a type leads to, and the way there."""
    if fields_of(annotation):
        yield way, annotation
        return
    origin = getattr(annotation, "__origin__", None)
    step = {dict: ".*", list: "[]", tuple: "[]"}.get(origin, "") if origin else ""
    for part in getattr(annotation, "__args__", ()):
        yield from sections(part, way + step)


def file_keys() -> Iterator[str]:
    roots = FILES | {f"kind {name}": kind_of(name).config for name in own_kinds()}
    for title, section in roots.items():
        yield from (f"{title}: {path}" for path in dict.fromkeys(keys(section)))


def own_kinds() -> list[str]:
    return sorted(name for name, point in kinds().items() if point.value.startswith("m4e_fmus."))


def options() -> Iterator[str]:
    """Arguments of each command; what has no default must be given."""
    commands = argparse.ArgumentParser().add_subparsers()
    for command in COMMANDS:
        command.add(commands.add_parser(command.__name__.rpartition(".")[2]))
    for name, parser in commands.choices.items():
        for action in parser._actions:
            choices = ", ".join(map(str, action.choices)) if action.choices else ""
            names = " ".join(action.option_strings) or action.dest
            yield f"{name} {names}{f' {{{choices}}}' if choices else ''}"


def public_names() -> Iterator[str]:
    """Names of the modules of docs/api, functions and classes with their parameters."""
    for page in sorted((ROOT / "docs" / "api").glob("*.md")):
        for module_name in re.findall(r"automodule:: (\S+)", page.read_text("utf-8")):
            module = importlib.import_module(module_name)
            yield from (f"{module_name}.{name}" for name in names_of(module))


def names_of(module: ModuleType) -> Iterator[str]:
    own = (n for n, v in vars(module).items() if getattr(v, "__module__", "") == module.__name__)
    for name in sorted(n for n in getattr(module, "__all__", own) if not n.startswith("_")):
        value = getattr(module, name)
        yield name + parameters(value)
        if inspect.isclass(value):
            for member, function in sorted(vars(value).items()):
                if not member.startswith("_"):
                    yield f"{name}.{member}{parameters(function)}"


def parameters(value: Any) -> str:
    """The names of what a function or a class takes; enumerations are not called."""
    if inspect.isclass(value) and issubclass(value, Enum):
        return ""
    if inspect.isclass(value) and issubclass(value, BaseModel):
        return f"({', '.join(value.model_fields)})"
    try:
        return f"({', '.join(inspect.signature(value).parameters)})" if callable(value) else ""
    except ValueError:
        return "(…)"


def variables() -> Iterator[str]:
    """Variables of the FMUs of some examples, with units; `#` stands for all numbers."""
    for name in SYSTEMS:
        system = load_system(EXAMPLES / name / "system.yaml")
        for component, description in expected_descriptions(system).items():
            for variable in description.variables.values():
                kind = f"{variable.variability} {variable.causality}"
                path = f"{component}.{NUMBER.sub('#', variable.name)}"
                yield f"{name}: {path} [{variable.unit}] {kind}"


def printed(folder: Path, said: pytest.CaptureFixture[str]) -> Iterator[str]:
    """Paths of all keys in what is printed with `--json`, and attributes of results."""
    with chdir(folder):
        model = str(EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml")
        times = [0.1 * k for k in range(400)]
        rows = [f"{t:.1f},{math.exp(-0.05 * t) * math.cos(t):.6f}" for t in times]
        Path("decay.csv").write_text("\n".join(["time [s],heave [m]", *rows]), "utf-8")
        main(["build", model, "--build-folder", "."])
        main(["simulate", model, "--stop-time", "1", "--output-file", "a.nc"])
        fmu = Path("double_pendulum.fmu")
        planted(fmu, Path("faulty.fmu"), b"modelName=", b'colour="red" modelName=')
        for command in (
            ("info", "double_pendulum.fmu"),
            ("validate", "faulty.fmu"),
            ("doctor",),
            ("equilibrium", model),
            ("linearize", model),
            ("compare", "a.nc", "a.nc", "--no-plot"),
            ("decay", "decay.csv", "--no-plot"),
        ):
            said.readouterr()
            main([*command, "--json"])
            found = json.loads(said.readouterr().out)
            yield from (f"{command[0]} --json: {path}" for path in dict.fromkeys(paths(found)))
        results = load("a.nc")
        yield from (f"results: attribute {name}" for name in sorted(results.attributes))
    for event, fields in EVENTS.items():
        yield from (f"--events: {event}.{field}" for field in fields)


def paths(value: Any, above: str = "") -> Iterator[str]:
    """Paths of all values; `*` stands for the name of a variable."""
    if isinstance(value, dict):
        for key, below in value.items():
            yield from paths(below, f"{above}.{'*' if '.' in key else key}".strip("."))
    elif isinstance(value, list):
        for below in value:
            yield from paths(below, f"{above}[]")
    else:
        yield above


def test_inventory(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], request: pytest.FixtureRequest
) -> None:
    parts = {
        "Keys of files": file_keys(),
        "Options": options(),
        "Public names": public_names(),
        "Variables": variables(),
        "Printed and written": printed(tmp_path, capsys),
    }
    found = "\n".join(
        "\n".join([f"# {title}", *dict.fromkeys(lines), ""]) for title, lines in parts.items()
    )
    if request.config.getoption("--update"):
        GOLDEN.write_text(found, "utf-8")
    assert found == GOLDEN.read_text("utf-8")
