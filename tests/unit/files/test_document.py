"""YAML documents: every problem at once, each where it stands, with what to do."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import pytest
from pydantic import Field, field_validator

from m4e_fmi.errors import InputError, Problem, suggestion
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


def test_right_document() -> None:
    text = (
        "name: a\ncount: 3\nmounts: {left: {at: [1, 2]}}\nparts: {p: {kind: rope, diameter: 0.1}}"
    )
    file = Document.parse(text).validate(File)
    assert (file.name, file.count, file.mounts["left"].at) == ("a", 3, (1.0, 2.0))
    assert isinstance(file.parts["p"], Rope)


SECTION = "expected 'key: value' lines, got"
PLACES = [  # text after the name, line, column and the word there, message, remedy
    ("cuont: 3", 2, 1, "cuont", "unknown key 'cuont'", "did you mean 'count'?"),
    ("qqq: 1", 2, 1, "qqq", "unknown key 'qqq'", "known keys: count, mounts, name, notes, parts"),
    ("mounts:\n  m:\n    at: [1, 2]\n    color: red", 5, 5, "color", "unknown key 'color'",
     "did you mean 'colour'?"),
    ("mounts: {m: {at: [1, 2], colour: gren}}", 2, 34, "gren", "unknown colour 'gren'",
     "did you mean 'green'?"),
    ("parts: {p: {kind: sprign, stiffness: 1}}", 2, 19, "sprign", "unknown kind 'sprign'",
     "did you mean 'spring'?"),
    # compared with members that have these keys, and with keys of the chosen member
    ("parts: {p: {kind: cord, diameter: 1}}", 2, 19, "cord", "unknown kind 'cord'",
     "known: rope"),
    ("parts: {p: {kind: sprope, diameter: 1, size: 2}}", 2, 19, "sprope",
     "unknown kind 'sprope'", "did you mean 'rope'?"),
    ("parts: {p: {kind: chain, links: 3}}", 2, 19, "chain", "unknown kind 'chain'",
     "known: rope, spring"),
    ("parts: {p: {kind: rope, diameter: 1, stiffness: 2}}", 2, 38, "stiffness",
     "unknown key 'stiffness'", "known keys: diameter, kind"),
    ("parts:\n  p: {stiffness: 1}", 3, 3, "p", "missing key 'kind'",
     "add 'kind: …' here, one of rope, spring"),
    ("parts: {p: {kind: rope}}", 2, 9, "p", "missing key 'diameter'", "add 'diameter: …' here"),
    ("parts: {p: {kind: rope, diamter: 1, diameter: 2}}", 2, 25, "diamter",
     "unknown key 'diamter'", "did you mean 'diameter'?"),
    ("mounts: {m: {at: [1, -2]}}", 2, 14, "at", "is below the ground: -2.0",
     "give a height above zero"),
    ("mounts: {m: {at: [1]}}", 2, 14, "at", "at: too few entries, got 1", "write 2 entries"),
    ("count: many", 2, 8, "many", "count: expected a whole number, got 'many'", ""),
    ("mounts: 7", 2, 9, "7", f"mounts: {SECTION} 7", ""),
    ("mounts:", 2, 1, "mounts", f"mounts: {SECTION} None", ""),
    ("mounts:\n  m: 7", 3, 6, "7", f"mounts.m: {SECTION} 7", "write m: {at: 7}"),
    ("mounts:\n  m:", 3, 3, "m", f"mounts.m: {SECTION} None", "write m: {at: …}"),
    ("notes: [one, [two]]", 2, 14, "[", "notes.1: expected text, got a list", ""),
]  # fmt: skip


@pytest.mark.parametrize(("text", "line", "column", "mark", "message", "remedy"), PLACES)
def test_place_message_and_remedy(
    text: str, line: int, column: int, mark: str, message: str, remedy: str
) -> None:
    (problem,) = problems(f"name: a\n{text}\n")
    assert (problem.line, problem.column, marked(problem)) == (line, column, mark)
    assert (problem.message, problem.remedy) == (message, remedy)
    assert problem.file == "some.yaml"


def test_words_that_are_equally_near_are_all_named() -> None:
    assert suggestion("spring", ["torsion_spring", "tension_spring", "force"]) == (
        "did you mean 'tension_spring' or 'torsion_spring'?"
    )


def test_all_problems_at_once_in_order_of_place() -> None:
    found = problems("cuont: 3\nmounts: {m: {at: [1, -2], colour: blue}}\n")
    assert [(p.line, p.message) for p in found] == [
        (0, "missing key 'name'"),
        (1, "unknown key 'cuont'"),
        (2, "is below the ground: -2.0"),
        (2, "unknown colour 'blue'"),
    ]


def test_carets_end_with_the_line() -> None:
    """A value that spans lines is longer than the line it starts on."""
    (problem,) = problems("name: a\ncount: >\n  many words\n  that go on and on\n")
    assert problem.column + problem.width - 1 <= len(problem.source)


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


@pytest.mark.parametrize(("given", "column", "remedy"), [
    ("{kind: rope, diameter: x, start: 1}", 29, ""),
    ("", 3, "write p: {"), ("3", 6, "write p: {"), ("[1, 2]", 3, "write p: {"),
])  # fmt: skip
def test_part_of_a_document(given: str, column: int, remedy: str) -> None:
    document = Document.parse(f"parts:\n  p: {given}\n", "file.yaml")
    with pytest.raises(InputError) as caught:
        document.validate(Rope, at=("parts", "p"), drop=("start",))
    (problem,) = caught.value.problems
    assert (problem.line, problem.column) == (2, column)
    assert problem.remedy.startswith(remedy)


@pytest.mark.parametrize(("text", "mounts", "notes", "expected"), [
    ("name: a\nmounts: {m: {at: [1, 2]}}\n", ["m"], [], []),
    ("name: a\nmounts: {m: {at: [1, 2], hue: 1}, n: {at: 1}}\nparts: {p: {kind: chain}}\n",
     ["m"], [],
     ["unknown key 'hue'", "mounts.n.at: expected a list, got 1", "unknown kind 'chain'"]),
    ("mounts: {m: {at: [1, 2]}, n: {at: 1}}\n", ["m"], [],
     ["missing key 'name'", "mounts.n.at: expected a list, got 1"]),
    ("name: [1]\nmounts: {m: {at: [1, 2]}}\n", ["m"], [], ["name: expected text, got a list"]),
    ("name: a\nnotes:\n  - [1]\n  - fine\n  - [2]\n", [], ["fine"],
     ["notes.0: expected text, got a list", "notes.2: expected text, got a list"]),
])  # fmt: skip
def test_as_far_as_possible(
    text: str, mounts: list[str], notes: list[str], expected: list[str]
) -> None:
    """The entries that are right can be looked at although others are wrong."""
    section, found = Document.parse(text).validate_as_far_as_possible(File, required={"name": "?"})
    assert section is not None
    assert (list(section.mounts), section.notes, section.parts) == (mounts, notes, {})
    assert sorted(problem.message for problem in found) == sorted(expected)
