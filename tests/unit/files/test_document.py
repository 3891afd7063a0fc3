"""YAML documents: every problem at once, each where it stands, with what to do."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

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


def only(text: str) -> Problem:
    (problem,) = problems(text)
    return problem


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


@pytest.mark.parametrize(
    ("text", "line", "column", "mark", "message", "remedy"),
    [
        ("name: a\ncuont: 3\n", 2, 1, "cuont", "unknown key 'cuont'", "did you mean 'count'?"),
        (
            "name: a\nmounts:\n  m:\n    at: [1, 2]\n    color: red\n",
            5,
            5,
            "color",
            "unknown key 'color'",
            "did you mean 'colour'?",
        ),
        (
            "name: a\nmounts: {m: {at: [1, 2], colour: gren}}\n",
            2,
            34,
            "gren",
            "unknown colour 'gren'",
            "did you mean 'green'?",
        ),
        (
            "name: a\nparts: {p: {kind: sprign, stiffness: 1}}\n",
            2,
            19,
            "sprign",
            "unknown kind 'sprign'",
            "did you mean 'spring'?",
        ),
        (
            "name: a\nparts:\n  p: {stiffness: 1}\n",
            3,
            3,
            "p",
            "missing key 'kind'",
            "add 'kind: …' here, one of rope, spring",
        ),
        (
            "name: a\nparts: {p: {kind: rope}}\n",
            2,
            9,
            "p",
            "missing key 'diameter'",
            "add 'diameter: …' here",
        ),
        (
            "name: a\nparts: {p: {kind: rope, diamter: 1, diameter: 2}}\n",
            2,
            25,
            "diamter",
            "unknown key 'diamter'",
            "did you mean 'diameter'?",
        ),
        (
            "name: a\nmounts: {m: {at: [1, -2]}}\n",
            2,
            14,
            "at",
            "is below the ground: -2.0",
            "give a height above zero",
        ),
        (
            "name: a\nmounts: {m: {at: [1]}}\n",
            2,
            14,
            "at",
            "at: too few entries, got 1",
            "write 2 entries",
        ),
        (
            "name: a\ncount: many\n",
            2,
            8,
            "many",
            "count: expected a whole number, got 'many'",
            "",
        ),
        ("name: a\nmounts: 7\n", 2, 9, "7", "mounts: expected 'key: value' lines, got 7", ""),
        ("name: a\nmounts:\n", 2, 1, "mounts", "mounts: expected 'key: value' lines, got None", ""),
        (
            "name: a\nnotes: [one, [two]]\n",
            2,
            14,
            "[",
            "notes.1: expected text, got a list",
            "",
        ),
    ],
)
def test_place_message_and_remedy(
    text: str, line: int, column: int, mark: str, message: str, remedy: str
) -> None:
    problem = only(text)
    assert (problem.line, problem.column, marked(problem)) == (line, column, mark)
    assert (problem.message, problem.remedy) == (message, remedy)
    assert problem.file == "some.yaml"


def test_an_unknown_key_is_compared_with_those_of_the_chosen_member() -> None:
    problem = only("name: a\nparts: {p: {kind: rope, diameter: 1, stiffness: 2}}\n")
    assert problem.remedy == "known keys: diameter, kind"


@pytest.mark.parametrize(
    ("part", "remedy"),
    [
        ("{kind: cord, diameter: 1}", "known: rope"),  # no word is near, one has this key
        ("{kind: sprope, diameter: 1, size: 2}", "did you mean 'rope'?"),
        ("{kind: chain, links: 3}", "known: rope, spring"),
    ],
)
def test_an_unknown_member_is_compared_with_those_of_the_same_keys(part: str, remedy: str) -> None:
    assert only(f"name: a\nparts: {{p: {part}}}\n").remedy == remedy


@pytest.mark.parametrize(
    ("given", "remedy"),
    [("7", "write m: {at: 7}"), ("high", "write m: {at: …}"), ("", "write m: {at: …}")],
)
def test_a_value_where_a_section_is_expected(given: str, remedy: str) -> None:
    assert only(f"name: a\nmounts:\n  m: {given}\n").remedy == remedy


def test_words_that_are_equally_near_are_all_named() -> None:
    assert suggestion("spring", ["torsion_spring", "tension_spring", "force"]) == (
        "did you mean 'tension_spring' or 'torsion_spring'?"
    )


def test_an_unknown_key_without_a_near_one_lists_what_there_is() -> None:
    assert only("name: a\nqqq: 1\n").remedy == "known keys: count, mounts, name, notes, parts"


def test_a_missing_key_of_the_top_level_has_the_file_as_its_place() -> None:
    problem = only("count: 3\n")
    assert str(problem) == "some.yaml: missing key 'name'\n      add 'name: …' here"


def test_all_problems_at_once_in_order_of_place() -> None:
    found = problems("cuont: 3\nmounts: {m: {at: [1, -2], colour: blue}}\nname: [1]\n")
    assert [(p.line, p.message) for p in found] == [
        (1, "unknown key 'cuont'"),
        (2, "is below the ground: -2.0"),
        (2, "unknown colour 'blue'"),
        (3, "name: expected text, got a list"),
    ]


def test_a_message_shows_line_number_source_and_carets() -> None:
    with pytest.raises(InputError) as caught:
        Document.parse("name: a\ncuont: 3\nnmae: b\n", "some.yaml").validate(File)
    assert str(caught.value) == (
        "some.yaml:2:1: unknown key 'cuont'\n"
        "    2 | cuont: 3\n"
        "      | ^^^^^\n"
        "      did you mean 'count'?\n"
        "some.yaml:3:1: unknown key 'nmae'\n"
        "    3 | nmae: b\n"
        "      | ^^^^\n"
        "      did you mean 'name'?\n"
        "2 problems"
    )


def test_carets_end_with_the_line() -> None:
    """A value that spans lines is longer than the line it starts on."""
    problem = only("name: a\ncount: >\n  many words\n  that go on and on\n")
    assert problem.column + problem.width - 1 <= len(problem.source)


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("name: a\nname: b\n", 2, 1, 'a key is given twice: found duplicate key "name"'),
        ("name: a\nmounts: {m: {at: [1, 2]}, m: {at: [1, 2]}}\n", 2, 27, 'duplicate key "m"'),
        ("name: a\nmounts: {m: 1\n", 3, 1, "not valid YAML"),
        ("name: a\n\tcount: 1\n", 2, 1, "not valid YAML"),
        ("name: a: b\n", 1, 8, "not valid YAML"),
        ("name: a\n---\nname: b\n", 2, 1, "not valid YAML"),
        ("name: *nobody\n", 1, 7, "not valid YAML"),
        ("name: {{a: {b: 1}}: 2}\n", 0, 0, "a key is not a plain word"),
        ('name: a\nmounts: {"\\ud800": 1}\n', 2, 1, "a key has \\ud800, half a character"),
    ],
)
def test_what_is_no_yaml(text: str, line: int, column: int, message: str) -> None:
    problem = only(text)
    assert (problem.line, problem.column) == (line, column)
    assert message in problem.message
    assert problem.remedy


@pytest.mark.parametrize(
    "text", ["", "just text", "- a\n- b\n", "name: \x07\n", "name: " + "[" * 400 + "]" * 400]
)
def test_what_is_no_mapping_is_refused_without_a_crash(text: str) -> None:
    assert only(text).message


def test_merged_keys_and_anchors() -> None:
    text = (
        "name: a\n"
        "mounts:\n  m: &m {at: [1, 2], colour: green}\n  n: {<<: *m, at: [3, 4]}\n  o: *m\n"
    )
    mounts = Document.parse(text).validate(File).mounts
    assert (mounts["n"].at, mounts["n"].colour) == ((3.0, 4.0), "green")
    assert mounts["o"] == mounts["m"]


def test_a_problem_of_a_merged_key_stands_where_it_is_merged() -> None:
    found = problems("name: a\nmounts:\n  m: &m {at: [1, -2]}\n  n: {<<: *m, colour: red}\n")
    assert [(p.line, marked(p)) for p in found] == [(3, "at"), (4, "n")]


def test_missing_file_suggests_a_near_one(tmp_path: Path) -> None:
    (tmp_path / "buoy.model.yaml").write_text("name: a\n")
    with pytest.raises(InputError) as caught:
        Document.load(tmp_path / "buoi.model.yaml")
    (problem,) = caught.value.problems
    assert problem.message == "no such file"
    assert problem.remedy == "did you mean 'buoy.model.yaml'?"
    assert problem.file == str(tmp_path / "buoi.model.yaml")


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "latin.yaml").write_bytes("name: é\n".encode("latin-1"))
    for path in (tmp_path, tmp_path / "latin.yaml"):
        with pytest.raises(InputError, match="cannot be read"):
            Document.load(path)


def test_a_byte_order_mark_and_windows_line_ends_do_not_shift_places(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes("\ufeffcuont: 3\r\nname: a\r\nmonts: {}\r\n".encode())
    with pytest.raises(InputError) as caught:
        Document.load(path).validate(File)
    assert [(p.line, marked(p)) for p in caught.value.problems] == [(1, "cuont"), (3, "monts")]


def test_part_of_a_document_with_keys_dropped() -> None:
    document = Document.parse("parts:\n  p: {kind: rope, diameter: x, start: 1}\n")
    with pytest.raises(InputError) as caught:
        document.validate(Rope, at=("parts", "p"), drop=("start",))
    (problem,) = caught.value.problems
    assert (problem.line, problem.column, marked(problem)) == (2, 29, "x")


class TestAsFarAsPossible:
    """The entries that are right can be looked at although others are wrong."""

    @staticmethod
    def parsed(text: str) -> tuple[Any, list[str]]:
        document = Document.parse(text)
        section, found = document.validate_as_far_as_possible(File, required={"name": "?"})
        return section, [problem.message for problem in found]

    def test_right_document(self) -> None:
        section, found = self.parsed("name: a\nmounts: {m: {at: [1, 2]}}\n")
        assert (section.name, list(section.mounts), found) == ("a", ["m"], [])

    def test_wrong_entries_are_left_out_and_unknown_keys_ignored(self) -> None:
        section, found = self.parsed(
            "name: a\nmounts: {m: {at: [1, 2], hue: 1}, n: {at: 1}}\nparts: {p: {kind: chain}}\n"
        )
        assert list(section.mounts) == ["m"]
        assert section.parts == {}
        assert sorted(found) == [
            "mounts.n.at: expected a list, got 1",
            "unknown key 'hue'",
            "unknown kind 'chain'",
        ]

    @pytest.mark.parametrize(
        ("name", "message"),
        [("", "missing key 'name'"), ("name: [1]\n", "name: expected text, got a list")],
    )
    def test_required_key_of_the_top_level(self, name: str, message: str) -> None:
        section, found = self.parsed(name + "mounts: {m: {at: [1, 2]}, n: {at: 1}}\n")
        assert list(section.mounts) == ["m"]
        assert found == [message, "mounts.n.at: expected a list, got 1"]

    def test_several_wrong_entries_of_a_list_keep_their_places(self) -> None:
        document = Document.parse("name: a\nnotes:\n  - [1]\n  - fine\n  - [2]\n  - [3]\n")
        section, found = document.validate_as_far_as_possible(File, required={})
        assert section is not None
        assert section.notes == ["fine"]
        assert [problem.line for problem in found] == [3, 5, 6]


@pytest.mark.parametrize("given", ["", "3", "[1, 2]"])
def test_part_of_a_document_that_is_no_section(given: str) -> None:
    document = Document.parse(f"parts:\n  p: {given}\n", "file.yaml")
    with pytest.raises(InputError) as caught:
        document.validate(Rope, at=("parts", "p"))
    (problem,) = caught.value.problems
    assert problem.line == 2
    assert "expected 'key: value' lines" in problem.message
    assert problem.remedy.startswith("write p: {")
