"""Means over seeds, and one number of each design over all sea states."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import t as student

from m4e_fmi.statistics import STATISTICS
from m4e_fmi.study.given.grid import Axis, Grid, Varied
from m4e_fmi.study.given.study import Wanted
from m4e_fmi.study.shown.over_states import LARGEST, States, averaged, differences, over_states

SEEDS, DESIGNS = 3, 2
STATES = States(("height", "period"), np.array([[0.5, 0.25], [0.0, 0.25]]))


def axis(name: str, count: int, *, repeats: bool = False) -> Axis:
    points = tuple((k,) for k in range(count))
    return Axis(name, (Varied(name, (name,)),), points, repeats=repeats)


GRID = Grid(
    (axis("period", 2), axis("seed", SEEDS, repeats=True), axis("x", DESIGNS), axis("height", 2))
)
VALUES = np.random.default_rng(1).uniform(1.0, 2.0, GRID.shape)
VALUES[0, :, :, 1] = 100.0  # of the state that never occurs


def half_width(sums: np.ndarray) -> np.ndarray:
    """Of 95 %, of the means over the last axis."""
    n = sums.shape[-1]
    return student.ppf(0.975, n - 1) * sums.std(axis=-1, ddof=1) / np.sqrt(n)


def test_means_over_seeds_have_students_interval() -> None:
    axes = (axis("seed", 4, repeats=True), axis("x", 2))
    values = np.array([[1.0, 5.0], [2.0, 5.0], [3.0, 5.0], [4.0, np.nan]])
    found = averaged(axes, values)
    np.testing.assert_allclose(found.mean, [2.5, 5.0])
    width = student.ppf(0.975, 3) * np.std([1, 2, 3, 4], ddof=1) / 2
    np.testing.assert_allclose(found.half_width, [float(width), 0.0])
    assert found.missing.tolist() == [0, 1]


@pytest.mark.parametrize(
    ("statistic", "parameters", "power", "said"),
    [
        ("mean", (), 1.0, "mean by probability"),
        ("rms", (), 2.0, "rms by probability"),
        ("damage_equivalent_load", (("exponent", 5.0),), 5.0, "damage equivalent by probability"),
    ],
)
def test_sums_over_states_of_each_design(
    statistic: str, parameters: tuple[tuple[str, float], ...], power: float, said: str
) -> None:
    name, found = over_states(GRID, VALUES, STATES, Wanted("w", "v", statistic, parameters))
    assert name == said
    assert [one.name for one in found.axes] == ["x"]
    sums = np.einsum("psxh,hp->xs", VALUES**power, STATES.shares) ** (1 / power)
    np.testing.assert_allclose(found.mean, sums.mean(axis=-1), rtol=1e-12)
    np.testing.assert_allclose(found.half_width, half_width(sums), rtol=1e-9)


@pytest.mark.parametrize(("statistic", "sign"), [("most_probable_maximum", 1), ("minimum", -1)])
def test_extremes_are_those_of_a_state(statistic: str, sign: int) -> None:
    _, found = over_states(GRID, sign * VALUES, STATES, Wanted("w", "v", statistic))
    means = VALUES.mean(axis=1)  # period, x, height
    there = np.stack([means[0, :, 0], means[1, :, 0], means[1, :, 1]], axis=-1)
    np.testing.assert_allclose(found.mean, sign * there.max(axis=-1))


def test_a_failed_seed_is_missing_in_the_sum() -> None:
    values = VALUES.copy()
    values[0, 1, 0, 0] = np.nan
    _, found = over_states(GRID, values, STATES, Wanted("w", "v", "mean"))
    assert found.missing.tolist() == [1, 0]
    assert np.isfinite(found.mean).all()


def test_differences_of_designs_are_those_of_pairs() -> None:
    """What a seed does to both designs is not in the interval."""
    seed = 50.0 * np.arange(SEEDS)[:, None, None]
    found = differences(GRID, VALUES + seed, STATES, Wanted("w", "v", "mean"))
    sums = np.einsum("psxh,hp->xs", VALUES, STATES.shares)
    two = Grid((axis("x", DESIGNS), axis("seed", SEEDS, repeats=True)))
    of_a_state = VALUES[1, :, :, 0].T
    pair = differences(two, of_a_state, None, Wanted("w", "v", "maximum"))
    for one, gain in ((found, sums[1] - sums[0]), (pair, of_a_state[1] - of_a_state[0])):
        assert one is not None
        np.testing.assert_allclose(one.mean, [0.0, gain.mean()], rtol=1e-9)
        np.testing.assert_allclose(one.half_width[1], half_width(gain), rtol=1e-9)
    alone = Grid((axis("seed", 1, repeats=True), axis("x", DESIGNS)))
    for grid, values, states, statistic in (
        (GRID, VALUES, STATES, "maximum"),
        (GRID, VALUES, None, "mean"),  # of 8 designs
        (alone, np.ones((1, 2)), None, "mean"),
    ):
        assert differences(grid, values, states, Wanted("w", "v", statistic)) is None


def test_all_statistics_of_maxima_are_known() -> None:
    assert {name for name in STATISTICS if "maximum" in name} | {"range", "largest_magnitude"} == (
        LARGEST
    )
