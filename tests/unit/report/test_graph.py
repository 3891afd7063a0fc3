"""The graph of a system in texts: every timing of an input has its rank and its colour."""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim import Timing
from m4e_fmi.report.drawing.system_graph import BOX, OF_TIMING, graph_figure, layout
from m4e_fmi.report.graph import TIMINGS, Arrow, Component, Graph


def test_every_timing_has_a_rank_and_a_colour() -> None:
    names = {timing.name for timing in Timing}
    assert set(TIMINGS) == names
    assert set(OF_TIMING) == names


def test_a_graph_is_drawn_from_its_texts() -> None:
    """Components, arrows, and a legend of what occurs."""
    graph = Graph(
        title="two",
        algorithm="jacobi",
        components=(Component("a", "a.fmu"), Component("b", "1 input unconnected")),
        arrows=(Arrow("a", "b", "x, vx", timing="DELAYED"), Arrow("b", "a", "m", once=True)),
        timings={"DELAYED": "one step late"},
    )
    (axis,) = graph_figure(graph).axes
    texts = {text.get_text() for text in axis.texts}
    assert {"a", "b", "a.fmu", "1 input unconnected", "x, vx", "m"} <= texts
    legend = axis.get_legend()
    assert legend is not None
    shown = [text.get_text() for text in legend.get_texts()]
    assert shown == ["one step late", "transferred once, at initialisation"]


def test_parts_that_nothing_connects_stand_in_rows() -> None:
    """Thirty pairs: no picture fifty times wider than high, and no box on another."""
    pairs = [(f"a{k}", f"b{k}") for k in range(30)]
    names = [name for pair in pairs for name in pair]
    places = layout(names, pairs)
    assert set(places) == set(names)
    centres = np.array([places[name] for name in names])
    width, height = np.ptp(centres, axis=0)
    assert 0.5 < width / height < 4.0
    apart = np.abs(centres[:, None] - centres[None, :])
    on_another = (apart < np.array(BOX)).all(axis=2)
    assert int(on_another.sum()) == len(names)  # each with itself
    two = layout(names[:4], pairs[:2])
    assert np.ptp([place[1] for place in two.values()]) < 1e-6  # a short row is one
