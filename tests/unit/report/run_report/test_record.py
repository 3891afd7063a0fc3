"""Records of runs, which results carry: what is read is what was written; damage is refused."""

from __future__ import annotations

import json

import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.report.graph import Arrow, Component, Graph
from m4e_fmi.report.run_report.record import (
    ATTRIBUTE,
    END,
    Flow,
    FlowEnergy,
    InputFile,
    Product,
    Record,
    RecordEnd,
    StatedError,
    carried_record,
    end_of,
    record_of,
)

RECORD = Record(
    graph=Graph(
        "a system", "jacobi",
        (Component("a", "a.fmu"), Component("b", "1 input unconnected", looped=True)),
        (Arrow("a", "b", "x, vx", timing="KNOWN"), Arrow("b", "a", "y", once=True)),
        {"KNOWN": "in time"},
    ),
    flows=(Flow("a.p <-> b.p", "a", "b", (Product("a.p.force_x", "b.p.vx", 1e3),), ("c", "d")),),
    inputs=(InputFile("s.yaml", "ab", "name: </script>\n"), InputFile("big.nc", "cd", None)),
    fmus={"a": "a.fmu, SHA-256 0"},
    seeds={"components.a.seed": "1"},
    versions={"Python": "3.11"},
)  # fmt: skip
ENDED = RecordEnd(
    steps=3,
    rejected=1,
    energies=(FlowEnergy(1.0, 1.1, 2.0, 1e-9),),
    errors=(StatedError("a.p <-> b.p", "b.p.vx", 1e-3, 1e-4, 2.0, "m/s"),),
)


def test_what_is_read_is_what_was_written() -> None:
    attributes = {**carried_record(RECORD), **carried_record(ENDED)}
    assert record_of(attributes, "r.nc") == RECORD
    assert end_of(attributes, "r.nc") == ENDED


def test_results_without_a_record_have_an_empty_one() -> None:
    assert record_of({}, "r.nc") == Record()
    assert end_of({}, "r.nc") == RecordEnd()


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{", '{"graph": 3}', '{"flows": [{"connection": 1}]}', "[" * 100_000, "\ud800"],
)
def test_damage_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"r\.nc: its record of the run is damaged.*\n.*run it"):
        record_of({ATTRIBUTE: text}, "r.nc")


@pytest.mark.parametrize(
    "graph",
    [
        Graph("none", "jacobi", (), ()),
        Graph("twice", "jacobi", (Component("a", ""), Component("a", "")), ()),
        Graph("loose", "jacobi", (Component("a", ""),), (Arrow("a", "b", "x"),)),
    ],
)
def test_a_graph_without_its_ends_is_refused(graph: Graph) -> None:
    with pytest.raises(InputError, match="damaged"):
        record_of(carried_record(Record(graph=graph)), "r.nc")


def test_every_cut_of_a_record_is_refused() -> None:
    text = carried_record(RECORD)[ATTRIBUTE]
    for length in range(0, len(text), 17):
        with pytest.raises(InputError, match="damaged"):
            record_of({ATTRIBUTE: text[:length]}, "r.nc")


def test_a_newer_format_is_refused() -> None:
    with pytest.raises(InputError, match=r"format 2, newer than this m4e_fmi.*\n.*update m4e_fmi"):
        end_of({END: json.dumps({"format": 2})}, "r.nc")
