"""Faults that a campaign plants are still in the code: it runs seldom."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.planted_faults import FAULTS

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_of_one_place(name: str) -> None:
    fault = FAULTS[name]
    fault.file(ROOT)
    assert fault.planted != fault.original
    assert all((ROOT / "tests" / test).exists() for test in fault.tests.split())
