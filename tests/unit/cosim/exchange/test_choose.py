"""The readings of outputs that count: the same by C and by Python, also if they are not finite."""

from __future__ import annotations

from itertools import product
from typing import cast

import numpy as np
import pytest

from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.cosim.exchange.native_executor import NOT_A_NUMBER, NativeExecutor
from m4e_fmi.cosim.exchange.operations import Choose
from m4e_fmi.cosim.exchange.python_executor import PythonExecutor
from m4e_fmi.cosim.exchange.rereading import ROWS
from m4e_fmi.runtime.library import library

NAN, INF = np.nan, np.inf


@pytest.mark.parametrize("kind", [float, np.int64])
@pytest.mark.parametrize("checked", [False, True])
def test_both_executors_choose_alike(kind: type, checked: bool) -> None:
    reals = (0.0, 1.0, 1.0 + 1e-12, -3.0, NAN, INF, -INF)
    values = reals if kind is float else (0, 1, -(2**62), 2**62 + 1)
    given = np.array(list(product(values, repeat=4)), dtype=kind).T
    found = library()
    assert found
    results = []
    for make in (lambda o: NativeExecutor(found, [o]), lambda o: PythonExecutor([o])):
        readings = np.zeros((ROWS, given.shape[1]), dtype=kind)
        readings[:4] = given
        into = np.zeros(given.shape[1], dtype=kind)
        chosen = Choose(cast(Instance, None), (), into, readings, checked=checked)
        status, _ = make(chosen).perform(0.0, 0.0, 0)
        assert (status == NOT_A_NUMBER) is (checked and kind is float)
        results.append((into, readings))
    for native, own in zip(*results, strict=True):
        np.testing.assert_array_equal(native, own)
