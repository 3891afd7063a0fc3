"""Operations of the loop over steps: the same in C and in Python, also if values are not finite."""

from __future__ import annotations

from itertools import product
from typing import Any, cast

import numpy as np
import pytest
from support.python_executor import PythonExecutor

from m4e_fmi.cosim.network.arrivals import ROWS
from m4e_fmi.cosim.network.operations import Choose, Monitor
from m4e_fmi.cosim.network.schedule import NOT_A_NUMBER, NativeExecutor

NAN, INF = np.nan, np.inf


@pytest.mark.parametrize("kind", [float, np.int64])
@pytest.mark.parametrize("checked", [False, True])
def test_both_executors_choose_alike(kind: type, checked: bool) -> None:
    reals = (0.0, 1.0, 1.0 + 1e-12, -3.0, NAN, INF, -INF)
    values = reals if kind is float else (0, 1, -(2**62), 2**62 + 1)
    given = np.array(list(product(values, repeat=4)), dtype=kind).T
    results = []
    for make in (NativeExecutor, PythonExecutor):
        readings = np.zeros((ROWS, given.shape[1]), dtype=kind)
        readings[:4] = given
        into = np.zeros(given.shape[1], dtype=kind)
        chosen = Choose(cast(Any, None), (), into, readings, checked=checked)
        status, _ = make([chosen]).perform(0.0, 0.0, 0)
        assert (status == NOT_A_NUMBER) is (checked and kind is float)
        results.append((into, readings))
    for native, own in zip(*results, strict=True):
        np.testing.assert_array_equal(native, own)


STEP = 0.05


def found(course: np.ndarray, *, native: bool = False, gate: float = 1e-13) -> np.ndarray:
    """How many columns of a course (steps, n) are rough at once, for each step; and what is known.

    The last row is the state of the monitor.
    """
    count = course.shape[1]
    source, past, into = np.zeros(count), np.zeros(6 * count + 1), np.zeros((len(course), 1))
    past[-1] = 5
    monitor = Monitor(into, source, np.full(count, gate), past)
    executor = NativeExecutor([monitor]) if native else PythonExecutor([monitor])
    for row, values in enumerate(course):
        source[:] = values
        assert executor.perform(0.0, STEP, row) == (0, 0)
    return np.concatenate((into[:, 0], past))


def waves(steps: int) -> np.ndarray:
    t = STEP * np.arange(steps)
    return np.column_stack((np.sin(t), 3 * np.cos(2.2 * t + 1) + 0.1 * np.sin(7 * t), np.exp(-t)))


def test_a_smooth_course_has_no_kinks() -> None:
    assert not found(waves(2000))[:2000].any()


@pytest.mark.parametrize("derivative", [0, 1, 2, 3])
def test_a_kink_is_found_in_its_step_or_the_next(derivative: int) -> None:
    course, at = waves(400), 217.4
    beyond = np.maximum(np.arange(400) - at, 0.0) * STEP
    course[:, 0] += 2.0 * np.where(beyond > 0, beyond**derivative, 0.0)
    steps = np.flatnonzero(found(course)[:400])
    assert steps[0] in (218, 219)
    assert steps[-1] < 218 + 8


def test_a_course_that_stays_rough_is_nothing_new() -> None:
    course = waves(600)
    course[300:, 0] += 0.1 * np.random.default_rng(1).normal(size=300)
    steps = np.flatnonzero(found(course)[:600])
    assert steps[0] == 300
    assert len(steps[steps > 320]) < 30  # of 280


def test_c_and_python_give_the_same_bits() -> None:
    rng = np.random.default_rng(2)
    course = np.cumsum(rng.normal(size=(500, 7)), axis=0)
    course[200:300] = course[200]
    assert (found(course, native=True) == found(course)).all()
