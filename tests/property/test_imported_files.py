"""Files of others, damaged: a message or a model, never anything else.

Chrono's files and the paper's lists, as data with a few entries removed, exchanged, or replaced by
what does not belong there.
"""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import paper_listings
from support.chrono_files import chrono_model
from support.chrono_mechanisms import spatial_mechanism
from support.fuzz.trees import damaged_yaml

from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.model import Model
from m4e_fmi.model.chrono import model_of_chrono
from m4e_fmi.model.m4e import model_of_lists


def chrono() -> Any:
    lists = paper_listings.spiderfloat()
    lists["Force"].pop("CG")
    data = chrono_model(lists)
    data["model"]["motors"] = [
        {"name": "push", "type": "LINEAR", "guide": "FREE", "body1": "body 1", "body2": "base",
         "location": [10, 0, 6], "axis": [0, 0, 1], "actuation_type": "FORCE",
         "actuation_function": {"type": "SINE", "amplitude": 1, "frequency": 0.1}},
    ]  # fmt: skip
    data["model"]["body_loads"] = [
        {"name": "jet", "type": "FORCE", "body": "body 2", "load": [1, 0, 0], "point": [0, 0, 1]},
    ]
    return data


def lists() -> Any:
    found = paper_listings.spiderfloat()
    found["Force"]["CG"] = [[1, 0, "cos(t)", 0]]
    found |= {"ic": [0.0] * 18, "BodyDataSym": ["L"], "BodyDataNum": [2]}
    return json.loads(json.dumps(found, default=_plain))


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else float(value)


def chrono_in_space() -> Any:
    """Joints of four kinds one after the other."""
    whole = spatial_mechanism("UNIVERSAL", 0)
    for k, kind in enumerate(("SPHERICAL", "PRISMATIC", "CYLINDRICAL"), start=1):
        text = json.dumps(spatial_mechanism(kind, k)["model"])
        model = json.loads(text.replace("arm", f"arm{k}").replace("tip", f"tip{k}"))
        whole["model"]["bodies"].append(model["bodies"][1])
        whole["model"]["joints"] += model["joints"][2:]
        whole["model"]["motors"] += model["motors"][3:]
    return whole


FORMS = {
    "chrono": (chrono(), model_of_chrono),
    "chrono in space": (chrono_in_space(), model_of_chrono),
    "lists": (lists(), model_of_lists),
}


@pytest.mark.parametrize("form", FORMS)
def test_the_whole_is_a_model(form: str) -> None:
    whole, read = FORMS[form]
    text = json.dumps(whole).replace("NaN", ".nan")
    assert isinstance(read(Document.parse(text, "file.yaml")), Model)


@pytest.mark.verifies(
    "damaged files of Chrono and the paper give a message or a model",
    analytic="no other outcome",
    tolerance="identical",
)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("count", [25, pytest.param(1000, marks=pytest.mark.verify)])
def test_a_message_or_a_model(form: str, count: int, tmp_path: Path) -> None:
    whole, read = FORMS[form]
    sound, file = json.dumps(whole).encode(), tmp_path / "file.yaml"
    for seed in range(count):
        file.write_bytes(damaged_yaml(sound, random.Random(seed)))
        found: Model | InputError
        try:
            found = read(Document.load(file))
        except InputError as error:
            found = error
        assert isinstance(found, Model) or (found.problems and all(map(str, found.problems)))
