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
_WIDEST_GAP = 0.055  # of the axis, between labels


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
    """Names right of the axes, at the height of the lines' ends, pushed apart where they touch."""
    to_axes = axes.transData + axes.transAxes.inverted()
    places = sorted((to_axes.transform((n, t))[1], n, t, name, c) for n, t, name, c in ends)
    lowest = float("-inf")
    for height, n, t, name, colour in places:
        lowest = max(height, lowest + _WIDEST_GAP)
        axes.annotate(
            name,
            xy=(n, t),
            xytext=(1.03, lowest),
            textcoords="axes fraction",
            color=colour,
            va="center",
            arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.5, "alpha": 0.4},
        )
