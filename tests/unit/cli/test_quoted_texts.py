"""Texts of files from elsewhere in the output: none begins a line, none hides another.

Each file here holds texts with "\\nerror: forged", which would look like a line of the output.
"""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from support.packages import component, description, package

from m4e_fmi.cli import main
from m4e_fmi.cosim.run.checkpoint import checkpoint_of, read_checkpoint, write_checkpoint
from m4e_fmi.shown import cleaned, one_line

Fmus = Callable[[str], Path]
XML = "modelDescription.xml"
SYSTEM = """\
name: "a\\nerror: forged"
components: {{{name}: {{fmu: {fmu}}}}}
simulation: {{stop_time: 2, step_size: 0.1}}
"""


@pytest.fixture
def lines(capsys: pytest.CaptureFixture[str]) -> Callable[..., list[str]]:
    """Runs a command that ends with the exit code `code`; gives the lines of its output."""

    def run(code: int, *arguments: str | Path) -> list[str]:
        assert main([str(one) for one in arguments]) == code
        printed = "".join(capsys.readouterr())
        assert "forged" in printed
        return printed.splitlines()

    return run


def forged(lines: list[str]) -> list[str]:
    return [line for line in lines if line.startswith(("error: forged", "forged"))]


def with_text(fmu: Path, path: Path, old: str, new: str, **more: str) -> Path:
    """A copy of an FMU at `path` with another description, and `more` files."""
    with zipfile.ZipFile(fmu) as archive:
        content = {name: archive.read(name).decode("latin-1") for name in archive.namelist()}
    assert old in content[XML]
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in (content | {XML: content[XML].replace(old, new, 1)} | more).items():
            archive.writestr(name, data.encode("latin-1"))
    return path


@pytest.mark.parametrize(("old", "code", "command"), [
    ('description="', 0, ["info"]), ('unit="', 2, ["info"]), ('modelName="', 2, ["info"]),
    ('valueReference="', 2, ["info"]), ('unit="', 1, ["validate", "--only", "description"]),
])  # fmt: skip
def test_fmus(
    old: str, code: int, command: list[str], lines: Callable[..., list[str]], c_fmu: Fmus,
    tmp_path: Path,
) -> None:  # fmt: skip
    """In their descriptions, and names of files in them."""
    path = with_text(c_fmu("mass"), tmp_path / "x.fmu", old, f"{old}a&#10;error: forged ")
    assert not forged(lines(code, command[0], path, *command[1:]))
    more = {"binaries/x\nforged/a.so": ""}
    path = with_text(c_fmu("mass"), tmp_path / "y.fmu", "", "", **more)
    assert not forged(lines(2, "info", path))


@pytest.mark.parametrize("attribute", ['name="u"', 'kind="input"'])
def test_packages(
    attribute: str, lines: Callable[..., list[str]], c_fmu: Fmus, tmp_path: Path
) -> None:
    part = component("a", "s.fmu", "input u Real")
    assert attribute in part
    part = part.replace(attribute, attribute[:6] + "a&#10;error: forged" + '"')
    ssd = description(f"<ssd:Elements>{part}</ssd:Elements>")
    path = package(tmp_path / "s.ssp", ssd, {"resources/s.fmu": c_fmu("stage")})
    found = lines(2, "run", path)
    assert not forged(found)
    assert "end of line" in found[0] or "kind" in attribute


def test_checkpoints(
    lines: Callable[..., list[str]], c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("s.yaml").write_text(SYSTEM.format(name="a", fmu=c_fmu("mass+state+bytes")))
    lines(0, "run", "s.yaml", "--checkpoint-interval", "1", "--output-file", "r.nc", "--verbose")
    identity = {"recorded variables of a": "a\nerror: forged "}
    path = checkpoint_of("r.nc")
    write_checkpoint(path, replace(read_checkpoint(path).saved, identity=identity))
    resumed = ("run", "s.yaml", "--resume", "--stop-time", "3", "--output-file", "r.nc")
    assert not forged(lines(2, *resumed))


def test_characters_of_no_width_are_shown() -> None:
    assert cleaned("a\u200bb\u2060c\ufffad") == "a\ufffdb\ufffdc\ufffdd"
    assert cleaned("نمی\u200cخواهم") == "نمی\u200cخواهم"  # it separates letters
    assert one_line("a \n\tb\tc\u2028d\r\n") == "a b c\ufffdd\ufffd"
