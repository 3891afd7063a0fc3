"""Model files with random damage: a message or a model that runs, never a traceback, never code.

10,000 small files, and some of a long one. `python -m property.test_mutated_models 100000` from the
folder tests tries more of the long one.
"""

from __future__ import annotations

import random
import re
import sys
from pathlib import Path

import pytest
from ruamel.yaml import YAML
from support.flap_file import TEXT, WAVE

from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.model.yaml import model_of
from m4e_fmi.multibody import model_program

SOUND = (
    """\
name: pendulum
parameters: {L: {value: 80, unit: cm}}
bodies: {a: {mass: 2, inertia: L**2/6}}
joints:
  j: {type: revolute, child: a, joint_to_child: [0, -L/2], initial: {q: pi/6}}
loads:
  f: {type: joint_friction, joint: j, effort: 0.1, velocity: 0.01}
""",
    """\
name: slider
gravity: 0
bodies:
  a: {mass: 1, inertia: 1, added_mass: true}
  b: {mass: 1, inertia: 1}
joints:
  j: {type: prismatic, child: a, direction: [1, 0]}
  k: {type: floating, child: b, initial: {x: 2}}
points: {tip: {body: a, at: [0, 1]}, end: {body: b, at: [0, 0]}}
loads:
  s: {type: tension_spring, points: [tip, end], law: 3*l + l**3, length: 1}
""",
)
CORPUS = Path(__file__).parents[1] / "corpus" / "model.yaml"
WRONG = tuple(
    case["files"]["a.model.yaml"]
    for case in YAML(typ="safe", pure=True).load(CORPUS.read_text("utf-8"))["cases"].values()
)
EXECUTED = "executed"
WORDS = (
    *(
        "1e999",
        "1/0",
        "-",
        "**",
        "0.5",
        "null",
        "true",
        "~",
        "'",
        '"',
        "\t",
        "&a",
        "*a",
        "..",
        "!!",
    ),
    *("law", "l", "theta", "t", "abs(l)", "(l+1)**4", "max(", "joint.hinge.q", "__class__"),
    *(f"open('{EXECUTED}', 'w')", f"!!python/object/apply:open ['{EXECUTED}', 'w']"),
)


def words_of(text: str) -> list[str]:
    return re.findall(r"\w+|\W", text) or [""]


def damaged(seed: int, texts: tuple[str, ...]) -> str:
    """One of `texts` with one to three of its words changed, doubled, left out or exchanged."""
    r = random.Random(seed)
    words = words_of(r.choice(texts))
    others = [*sorted({*words}), *WORDS]
    for _ in range(r.choice([1, 1, 2, 3])):
        i, j = r.randrange(len(words)), r.randrange(len(words))
        match r.randrange(5):
            case 0 | 1:
                words[i] = r.choice(others)
            case 2:
                words.insert(i, r.choice(others))
            case 3 if len(words) > 1:
                del words[i]
            case _:
                words[i], words[j] = words[j], words[i]
    return "".join(words)


def check(seed: int, folder: Path, *texts: str) -> bool:
    """True if the damaged file is still a model. Any other error than ours is raised."""
    try:
        model = model_of(Document.parse(damaged(seed, texts), folder / "flap.model.yaml"))
    except InputError:
        return False
    assert model_program(model).states
    return True


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with what the long file names."""
    (tmp_path / "wave.csv").write_text(WAVE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.verifies(
    "damaged model files give a message or a model",
    analytic="no other outcome",
    tolerance="identical",
)
@pytest.mark.parametrize("block", range(4))
def test_damaged_files(block: int, folder: Path) -> None:
    models = sum(check(seed, folder, TEXT) for seed in range(100 * block, 100 * (block + 1)))
    assert 0 < models < 50
    assert not (folder / EXECUTED).exists()


@pytest.mark.parametrize("block", range(10))
def test_damaged_small_files(block: int, folder: Path) -> None:
    """Half of them were wrong before."""
    texts = (*SOUND * 45, *WRONG)
    models = sum(check(seed, folder, *texts) for seed in range(1000 * block, 1000 * (block + 1)))
    assert 10 < models < 300
    assert not (folder / EXECUTED).exists()


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "wave.csv").write_text(WAVE)
        count = int(sys.argv[1])
        print(sum(check(seed, Path(name), TEXT) for seed in range(count)), "models of", count)
