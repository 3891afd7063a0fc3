"""Model files with random damage: a message or a model that runs, never a traceback, never code.

A sample; `make verify` tries five times as many.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from ruamel.yaml import YAML
from support.flap_file import TEXT, WAVE
from support.fuzz.texts import WORDS, damaged_text
from support.sampling import blocks

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
OWN_WORDS = (
    *("-", "**", "0.5", "'", '"', "\t", "law", "l", "theta", "abs(l)", "(l+1)**4", "max("),
    *("joint.hinge.q", "__class__", f"open('{EXECUTED}', 'w')"),
    f"!!python/object/apply:open ['{EXECUTED}', 'w']",
)


def check(seed: int, folder: Path, *texts: str) -> bool:
    """True if one of `texts` with one to three pieces of damage is still a model.

    Any other error than ours is raised.
    """
    r = random.Random(seed)
    content = r.choice(texts).encode()
    for _ in range(r.choice([1, 1, 2, 3])):
        content = damaged_text(content, (*WORDS, *OWN_WORDS), r)
    try:
        model = model_of(Document.parse(content.decode(), folder / "flap.model.yaml"))
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
@pytest.mark.parametrize("block", blocks(1, 4))
def test_damaged_files(block: int, folder: Path) -> None:
    models = sum(check(seed, folder, TEXT) for seed in range(100 * block, 100 * (block + 1)))
    assert 0 < models < 50
    assert not (folder / EXECUTED).exists()


@pytest.mark.parametrize("block", blocks(1, 10))
def test_damaged_small_files(block: int, folder: Path) -> None:
    """Half of them were wrong before."""
    texts = (*SOUND * 45, *WRONG)
    models = sum(check(seed, folder, *texts) for seed in range(1000 * block, 1000 * (block + 1)))
    assert 10 < models < 300
    assert not (folder / EXECUTED).exists()
