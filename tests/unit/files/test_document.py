"""YAML documents: every problem at once, each where it stands, with what to do."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import pytest
from pydantic import Field, field_validator

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Document, Section, rejected


class Spring(Section):
    kind: Literal["spring"]
    stiffness: float


class Rope(Section):
    kind: Literal["rope"]
    diameter: float


class Mount(Section):
    at: tuple[float, float]
    colour: Literal["red", "green"] = "red"

    @field_validator("at")
    @classmethod
    def _above_ground(cls, at: tuple[float, float]) -> tuple[float, float]:
        if at[1] < 0:
            raise rejected(f"is below the ground: {at[1]}", "give a height above zero")
        return at


class File(Section):
    name: str
    count: int = 1
    mounts: dict[str, Mount] = Field(default_factory=dict)
    parts: dict[str, Annotated[Spring | Rope, Field(discriminator="kind")]] = Field(
        default_factory=dict
    )
    notes: list[str] = Field(default_factory=list)


def problems(text: str) -> list[Problem]:
    with pytest.raises(InputError) as caught:
        Document.parse(text, "some.yaml").validate(File)
    return caught.value.problems


def marked(problem: Problem) -> str:
    """The piece of the source line that the carets stand under."""
    return problem.source[problem.column - 1 : problem.column - 1 + problem.width]


def test_merged_keys_and_anchors() -> None:
    text = (
        "name: a\n"
        "mounts:\n  m: &m {at: [1, 2], colour: green}\n  n: {<<: *m, at: [3, 4]}\n  o: *m\n"
    )
    mounts = Document.parse(text).validate(File).mounts
    assert (mounts["n"].at, mounts["n"].colour) == ((3.0, 4.0), "green")
    assert mounts["o"] == mounts["m"]
    found = problems("name: a\nmounts:\n  m: &m {at: [1, -2]}\n  n: {<<: *m, colour: red}\n")
    assert [(p.line, marked(p)) for p in found] == [(3, "at"), (4, "n")]


def test_a_byte_order_mark_and_windows_line_ends_do_not_shift_places(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes("\ufeffcuont: 3\r\nname: a\r\nmonts: {}\r\n".encode())
    with pytest.raises(InputError) as caught:
        Document.load(path).validate(File)
    assert [(p.line, marked(p)) for p in caught.value.problems] == [(1, "cuont"), (3, "monts")]


@pytest.mark.parametrize(("given", "column", "message"), [
    ("{kind: rope, diameter: x, start: 1}", 29, "diameter: expected a number"),
    ("", 3, "p: expected 'key: value' lines"), ("3", 6, "p: expected 'key: value' lines"),
    ("[1, 2]", 3, "p: expected 'key: value' lines"),
])  # fmt: skip
def test_part_of_a_document(given: str, column: int, message: str) -> None:
    document = Document.parse(f"parts:\n  p: {given}\n", "file.yaml")
    with pytest.raises(InputError) as caught:
        document.validate(Rope, at=("parts", "p"), drop=("start",))
    (problem,) = caught.value.problems
    assert (problem.line, problem.column) == (2, column)
    assert problem.message.startswith(message)
