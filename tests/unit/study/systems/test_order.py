"""The order in which the runs of a study are made."""

import numpy as np

from m4e_fmi.study.given.grid import Axis, Grid, Varied
from m4e_fmi.study.systems.order import LongestFirst

SHAPE = (("a", 6), ("b", 8))


def test_no_process_waits_long_for_the_last_run() -> None:
    """Where times are sums over dimensions: the bound of longest-first is 4/3 - 1/(3 m).

    R. L. Graham (1969), Bounds on multiprocessing timing anomalies, SIAM J. Appl. Math. 17; that is
    for times that are known. A process that is free takes the next run.
    """
    times = np.add.outer(np.linspace(0, 0.2, 6), [1, 1, 1, 1, 1, 1, 1, 3.0]).ravel()
    axes = (Axis(a, (Varied(a, (f"x.{a}",)),), tuple((i,) for i in range(n))) for a, n in SHAPE)
    order, under_way, now = LongestFirst(range(48), Grid(tuple(axes))), dict[int, float](), 0.0
    waiting, done = iter(order), list[int]()
    while len(done) < 48:
        while len(under_way) < 4 and (run := next(waiting, None)) is not None:
            under_way[run] = now + times[run]
        run = min(under_way, key=under_way.__getitem__)
        now = under_way.pop(run)
        order.learn(run, times[run])
        done.append(run)
    assert sorted(done) == list(range(48))
    assert max(times[k::4].sum() for k in range(4)) > 1.2 * times.sum() / 4  # as given
    assert now < 1.05 * times.sum() / 4
