"""The figure: time of one right-hand side over the number of links, one line per engine."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

_STYLES = {  # colour-blind safe (Okabe and Ito), ours solid and dark
    "m4e_fmi compiled": ("#000000", "o", "-"),
    "m4e_fmi interpreted": ("#000000", "s", "--"),
    "m4e_fmi plain Python": ("#000000", "^", ":"),
    "Pinocchio ABA": ("#0072B2", "o", "-"),
    "MuJoCo mj_forward": ("#009E73", "o", "-"),
    "CasADi generated C": ("#E69F00", "o", "-"),
    "CasADi virtual machine": ("#E69F00", "s", "--"),
    "PyDy Cython": ("#56B4E9", "o", "-"),
    "SymPy Kane, lambdify": ("#CC79A7", "o", "-"),
    "pyM4E": ("#D55E00", "o", "-"),
}
_GAP = 0.048  # of the axes, between labels


def draw(columns: Mapping[str, Mapping[str, float] | None], path: Path) -> None:
    """Write the figure; `columns` maps n to engine to seconds."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8, 5), layout="constrained")
    ends = []
    for name, (colour, marker, line) in _STYLES.items():
        points = [
            (int(n), 1e6 * values[name])
            for n, values in columns.items()
            if values and name in values
        ]
        if not points:
            continue
        axes.plot(*zip(*points, strict=True), color=colour, marker=marker, linestyle=line, ms=5)
        ends.append((*points[-1], name, colour))
    axes.set(xscale="log", yscale="log", xlabel="links", ylabel="time of one right-hand side [µs]")
    sizes = [int(n) for n in columns]
    axes.set_xticks(sizes, [str(n) for n in sizes])
    axes.minorticks_off()
    axes.grid(color="0.9")
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_xlim(min(sizes) * 0.9, max(sizes) * 1.1)
    _label(axes, ends)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def _label(axes, ends: list[tuple[int, float, str, str]]) -> None:
    """Names right of the axes, near the heights of the lines' ends and in their order.

    A thin line leads from each end straight to the edge of the axes and from there to the name, so
    that it crosses no name and no other such line.
    """
    to_axes = axes.transData + axes.transAxes.inverted()
    ends = sorted(ends, key=lambda end: end[1])
    starts = [to_axes.transform((n, t)) for n, t, _, _ in ends]
    heights = _apart([height for _, height in starts])
    for (_, _, name, colour), (x, start), height in zip(ends, starts, heights, strict=True):
        axes.plot((x, 1.0, 1.06), (start, start, height), color=colour, lw=0.5, alpha=0.6,
                  transform=axes.transAxes, clip_on=False, zorder=1)  # fmt: skip
        axes.annotate(
            name, (1.07, height), xycoords="axes fraction", color=colour, va="center", fontsize=9.5
        )


def _apart(heights: list[float]) -> list[float]:
    """Ascending `heights`, moved as little as it takes for the gap between neighbours."""
    moved = list(heights)
    for _ in range(500):
        for k in range(len(moved) - 1):
            missing = max(0.0, _GAP - (moved[k + 1] - moved[k]))
            moved[k] -= missing / 2
            moved[k + 1] += missing / 2
    return moved
