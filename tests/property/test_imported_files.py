"""Files of others, damaged: a message or a model, never anything else.

Chrono's files and the paper's lists, as data with a few entries removed, exchanged, or replaced by
what does not belong there.
"""

from __future__ import annotations

import copy
import json
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support import paper_listings
from support.chrono_files import chrono_model
from support.chrono_mechanisms import spatial_mechanism

from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.model import Model
from m4e_fmi.model.chrono import model_of_chrono
from m4e_fmi.model.m4e import model_of_lists

STRANGE = (
    None, True, 0, -1, 1e308, float("nan"), float("inf"), "", "t", "x + y", "__import__('os')",
    "BD10", "ground", "REVOLUTE", [], [0], [0, 0, 0], {}, {"name": "a"}, [[0, 1]], 10**30,
    [[1, 2], [0, 1]], "R", "P", ["F"],
)  # fmt: skip


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


def places(data: Any, at: tuple = ()) -> list[tuple]:
    """Where every value of nested data stands."""
    if not isinstance(data, dict | list):
        return []
    items = data.items() if isinstance(data, dict) else enumerate(data)
    return [place for key, value in items for place in [(*at, key), *places(value, (*at, key))]]


@st.composite
def damaged(draw: st.DrawFn, whole: Any) -> Any:
    data = copy.deepcopy(whole)
    for _ in range(draw(st.integers(1, 4))):
        *parents, last = draw(st.sampled_from(places(data)))
        target = data
        for key in parents:
            target = target[key]
        match draw(st.sampled_from(("remove", "replace", "rename", "copy"))):
            case "remove":
                del target[last]
            case "rename" if isinstance(target, dict):
                target[draw(st.sampled_from(("", "name", "extra", "type")))] = target.pop(last)
            case "copy":
                other = draw(st.sampled_from(places(whole)))
                value = whole
                for key in other:
                    value = value[key]
                target[last] = copy.deepcopy(value)
            case _:
                target[last] = copy.deepcopy(draw(st.sampled_from(STRANGE)))
        if not places(data):
            break
    return data


@pytest.mark.verifies(
    "damaged files of Chrono and the paper give a message or a model",
    analytic="no other outcome",
    tolerance="identical",
)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("examples", [40, pytest.param(400, marks=pytest.mark.verify)])
def test_a_message_or_a_model(form: str, examples: int) -> None:
    unhurried = [HealthCheck.too_slow, HealthCheck.data_too_large]
    limits = settings(max_examples=examples, deadline=None, suppress_health_check=unhurried)
    limits(given(choice=st.data())(check))(form)


def check(form: str, choice: st.DataObject) -> None:
    whole, read = FORMS[form]
    data = choice.draw(damaged(whole))
    text = json.dumps(data).replace("NaN", ".nan").replace("Infinity", ".inf")
    try:
        model = read(Document.parse(text, "file.yaml"))
    except InputError as error:
        problems = error.problems
        model = None
    else:
        problems = []
    assert isinstance(model, Model) or (problems and all(p.message for p in problems))
