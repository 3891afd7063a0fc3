"""Model files with random damage: a message or a model that runs, never a traceback.

`python -m property.test_mutated_models 10000` from the folder tests tries more of them.
"""

from __future__ import annotations

import random
import re
import sys
from pathlib import Path

import pytest
from support.flap_file import TEXT, WAVE

from m4e_fmi.document import Document
from m4e_fmi.errors import InputError
from m4e_fmi.model.yaml import model_of
from m4e_fmi.multibody import model_program

TOKENS = re.findall(r"\w+|\W", TEXT)
WORDS = [
    *sorted(set(TOKENS)),
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
]


def damaged(seed: int) -> str:
    """The example with one to three of its words changed, doubled, left out or exchanged."""
    r = random.Random(seed)
    tokens = list(TOKENS)
    for _ in range(r.choice([1, 1, 2, 3])):
        i, j = r.randrange(len(tokens)), r.randrange(len(tokens))
        match r.randrange(5):
            case 0 | 1:
                tokens[i] = r.choice(WORDS)
            case 2:
                tokens.insert(i, r.choice(WORDS))
            case 3:
                del tokens[i]
            case _:
                tokens[i], tokens[j] = tokens[j], tokens[i]
    return "".join(tokens)


def check(seed: int, folder: Path) -> bool:
    """Whether the damaged file still says a model. Any other error than ours is raised."""
    try:
        model = model_of(Document.parse(damaged(seed), folder / "flap.model.yaml"))
    except InputError:
        return False
    assert model_program(model).states
    return True


@pytest.mark.verifies(
    "damaged model files give a message or a model",
    analytic="no other outcome",
    tolerance="identical",
)
@pytest.mark.parametrize("block", range(4))
def test_damaged_files(block: int, tmp_path: Path) -> None:
    (tmp_path / "wave.csv").write_text(WAVE)
    models = sum(check(seed, tmp_path) for seed in range(100 * block, 100 * (block + 1)))
    assert 0 < models < 50


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "wave.csv").write_text(WAVE)
        count = int(sys.argv[1])
        print(sum(check(seed, Path(name)) for seed in range(count)), "models of", count, "files")
