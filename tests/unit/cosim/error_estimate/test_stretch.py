"""Steps that are repeated together: what does not fit together is none of a run."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim.error_estimate.stretch import Stretch
from m4e_fmi.cosim.exchange.layout import NetworkSnapshot
from m4e_fmi.cosim.scenario.scenario import ScenarioSnapshot

NS = 10**7


def recorded(start: NetworkSnapshot) -> Stretch:
    """Three steps of two outputs."""
    stretch = Stretch(start, window=True, recorded=True, end=9, values=[np.zeros((4, 2))], last=0)
    stretch.go_on(3, NS)
    return stretch


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"values": [np.zeros((1, 2)), np.zeros((3, 3))]}, "the same outputs"),
        ({"values": [np.zeros(4)]}, "the same outputs"),
        ({"values": [np.zeros((3, 2))]}, "those of its steps"),
        ({"steps": 4}, "those of its runs"),
        ({"runs": [(NS, 4), (NS, -1)]}, "those of its runs"),
        ({"kinks": [np.array([1, 4])]}, "within it"),
    ],
)
def test_what_does_not_fit_together(
    change: dict[str, Any], why: str, start: NetworkSnapshot
) -> None:
    stretch = recorded(start)
    stretch.check()
    with pytest.raises(ValueError, match=why):
        replace(stretch, **change).check()


@pytest.fixture
def start() -> NetworkSnapshot:
    none, whole = np.zeros(0), np.zeros(0, np.int64)
    scenario = ScenarioSnapshot(0, (), (), (), (), ())
    return NetworkSnapshot(0, 0.0, 0.0, none, none, (whole, whole, ()), (), 0.0, scenario)
