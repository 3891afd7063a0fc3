"""The graph of a system in texts: every timing of an input has its rank and its colour."""

from __future__ import annotations

from m4e_fmi.cosim import Timing
from m4e_fmi.report.drawing.system_graph import OF_TIMING, graph_figure
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
