"""The order in which the runs of a study are made."""

import numpy as np

from m4e_fmi.study.given.grid import Axis, Grid, Varied
from m4e_fmi.study.systems.order import LongestFirst


def grid_of(*shape: int) -> Grid:
    """A grid of that shape."""
    axes = (
        Axis(f"a{k}", (Varied(f"a{k}", (f"x.a{k}",)),), tuple((i,) for i in range(n)))
        for k, n in enumerate(shape)
    )
    return Grid(tuple(axes))


def end_of_last(order: LongestFirst, times: np.ndarray, processes: int) -> float:
    """When the last run ends [s], if a process that is free takes the next one."""
    waiting, under_way = iter(order), dict[int, float]()
    now = 0.0
    while True:
        while len(under_way) < processes and (run := next(waiting, None)) is not None:
            under_way[run] = now + times[run]
        if not under_way:
            return now
        run = min(under_way, key=under_way.__getitem__)
        now = under_way.pop(run)
        order.learn(run, times[run])


def test_every_run_comes_once_and_in_order_where_nothing_is_known() -> None:
    assert list(LongestFirst([1, 4, 5], grid_of(2, 3))) == [1, 4, 5]
    assert list(LongestFirst([0], Grid(()))) == [0]


def test_the_longest_runs_come_before_others() -> None:
    order = LongestFirst(range(8), grid_of(2, 4))
    runs = iter(order)
    assert [next(runs), next(runs), next(runs)] == [0, 1, 2]
    order.learn(1, 2.0)
    order.learn(2, 5.0)
    assert next(runs) == 6  # at the point of 2 in the second dimension
    order.learn(6, 5.0)
    assert list(runs) == [4, 7, 3, 5]  # 6 was above the mean, so are those beside it; 1 was below


def test_no_process_waits_long_for_the_last_run() -> None:
    """Where times are sums over dimensions: the bound of longest-first is 4/3 - 1/(3 m).

    R. L. Graham (1969), Bounds on multiprocessing timing anomalies, SIAM J. Appl. Math. 17; that is
    for times that are known.
    """
    times = np.add.outer(np.linspace(0, 0.2, 6), [1, 1, 1, 1, 1, 1, 1, 3.0]).ravel()
    least = times.sum() / 4
    as_given = max(times[k::4].sum() for k in range(4))
    found = end_of_last(LongestFirst(range(48), grid_of(6, 8)), times, 4)
    assert found < 1.05 * least
    assert as_given > 1.2 * least
