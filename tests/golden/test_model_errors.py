"""Wrong model files, and word for word what is said about them: model_errors/<case>.txt.

`pytest --update` writes the messages anew.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.model import load_model

FOLDER = Path(__file__).with_name("model_errors")
CASES = sorted(path.name.removesuffix(".model.yaml") for path in FOLDER.glob("*.model.yaml"))


@pytest.mark.parametrize("case", CASES)
def test_message(case: str, request: pytest.FixtureRequest) -> None:
    path, golden = FOLDER / f"{case}.model.yaml", FOLDER / f"{case}.txt"
    with pytest.raises(InputError) as caught:
        load_model(path)
    text = str(caught.value).replace(str(path), path.name) + "\n"
    if request.config.getoption("--update"):
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")


def test_every_message_has_its_case() -> None:
    assert sorted(path.stem for path in FOLDER.glob("*.txt")) == CASES
