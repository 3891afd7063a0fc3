"""Reports of results as text: sections, figures, refusals, and texts that others have made."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.html_pages import Page
from support.reports import results_of

from m4e_fmi.errors import InputError
from m4e_fmi.report import report_of_run
from m4e_fmi.report.graph import Arrow, Graph, GraphComponent
from m4e_fmi.report.run_report.record import (
    ATTRIBUTE,
    Flow,
    FlowEnergy,
    InputFile,
    Product,
    Record,
    RecordEnd,
    StatedError,
    carried_record,
    record_of,
)
from m4e_fmi.results.row_file import NOT_ENDED

TIME = np.linspace(0.0, 10.0, 101)
HOSTILE = "</script><img src=x onerror=alert(1)>&%{y}\"'$x^$"


def report(path: Path, attributes: Mapping[str, str], **values: np.ndarray) -> Page:
    named = {name.replace("__", "."): one for name, one in values.items()}
    made = results_of(TIME, named, units=dict.fromkeys(named, "N"), attributes=attributes)
    return Page(report_of_run(made, path).read_text("utf-8"))


def data_of(page: Page) -> dict[str, Any]:
    """The data that the page starts with."""
    script = page.scripts[-1]
    start = script.rindex("start({") + len("start(")
    return json.JSONDecoder().raw_decode(script[start:])[0]


def test_the_summary_says_what_the_results_tell(tmp_path: Path) -> None:
    end = RecordEnd(
        steps=24000,
        rejected=7,
        errors=(StatedError("a.p <-> b.p", "a.x", 2e-3, 5e-4, 2.5, "N"),),
    )
    attributes = {
        "comment": "a comment", "algorithm": "gauss_seidel", "step_size": "0.025 s",
        "notes": "a note\nwarning: another", "messages": "fmu: beware", "ended": "failed: nan",
        **carried_record(end),
    }  # fmt: skip
    page = report(tmp_path / "r.html", attributes, a__x=np.sin(TIME))
    for text in (
        "a comment", "24,000 of 0.025 s, 7 made again", "gauss_seidel", "a note",
        "fmu: beware", "The run ended early: failed: nan.", "2.0e-03", "0.005 N",
        "0 to 10 s, 101 rows",
    ):  # fmt: skip
        assert text in page.text
    (variable,) = data_of(page)["samples"]["variables"]
    assert variable["stated"] == "2.0e-03 of range, 0.005 N"
    page = report(tmp_path / "r.html", {"ended": NOT_ENDED, "step_size": "0.1 s"}, a__x=TIME)
    assert "The run has not ended yet: the run goes on, or its process was killed." in page.text
    assert "0.1 s each" in page.text
    (policy,) = [given["content"] for tag, given in page.tags if "http-equiv" in given]
    assert str(policy).startswith("default-src 'none';")
    links = [str(given["href"]) for _, given in page.tags if "href" in given]
    assert links
    assert all(link.startswith("#") for link in links)  # the page asks for nothing
    assert not re.search(r"https?://(?!www\.w3\.org)", "".join(page.scripts[-1:]))


def test_doubts_come_second_and_only_if_there_are_any(tmp_path: Path) -> None:
    """Before the numerics: each doubt in words; without one the accuracy, the largest error."""
    small = StatedError("a <-> b", "a.x", 2e-3, 5e-4, 2.5, "N")
    flows = (Flow("a <-> b", "b", "a", ()), Flow("a <-> c", "c", "a", ()))
    energies = (FlowEnergy(1.0, 0.97, 1.0), FlowEnergy(1e-9, 0.0, 1e-9, noise=1e-8))
    large, record = replace(small, error=0.02), carried_record(Record(flows=flows))
    for attributes, said in (
        (carried_record(RecordEnd(errors=(small,))), []),
        ({"notes": "a note"}, []),
        ({"notes": "a note\nwarning: beware"}, ["beware"]),
        ({"messages": "fmu, error at t = 3 s: no"}, ["Message of fmu, error at t = 3 s: no"]),
        ({"coupling_error": "not known: no saved states"}, ["Coupling error not known: no saved"]),
        ({"coupling_error": "the coupling error is not known"}, ["Coupling error is not known"]),
        ({"coupling_error": "largest", **carried_record(RecordEnd(errors=(large,)))}, ["Largest"]),
        (record | carried_record(RecordEnd(energies=energies)), ["a <-> b loses 3.0000 % of"]),
        ({"ended": NOT_ENDED}, ["The run has not ended yet"]),
    ):
        page = report_of_run(
            results_of(TIME, {"a.x": TIME}, attributes=attributes), tmp_path / "r.html"
        )
        section = html.unescape(
            page.read_text("utf-8").split('id="warnings"')[1].split("</section>")[0]
        )
        assert section.count("<li>") == len(said), section
        assert all(f"<li>{text}" in section for text in said), section
        assert ("No warnings" in section) == (not said)
    first = report(tmp_path / "r.html", carried_record(RecordEnd(errors=(small,))), a__x=TIME).text
    places = [first.rindex(text) for text in (
        "0.00 to 10.00 N", "No warnings; largest coupling error 0.2 % of range, at a.x.",
        "Search variables", "logarithmic", "Stated coupling errors", "carry no scene",
        "no record of versions",
    )]  # fmt: skip
    assert places == sorted(places)


def test_powers_over_connections_are_forces_times_velocities(tmp_path: Path) -> None:
    force, velocity = np.cos(TIME), np.sin(TIME) ** 2
    product = Product("b.p.force_x", "a.p.vx", 2.0)
    flow = Flow("a.p <-> b.p", "b", "a", (product,), ("c", "d"))
    exact = float(np.trapezoid(2 * force * velocity, TIME))
    ends = RecordEnd(energies=(FlowEnergy(exact + 0.02, exact, 2.0),))
    attributes = {**carried_record(Record(flows=(flow,))), **carried_record(ends)}
    page = report(tmp_path / "r.html", attributes, b__p__force_x=force, a__p__vx=velocity)
    flows = data_of(page)["flows"]
    (one,) = flows["flows"]
    assert [one[key] for key in ("name", "source", "target", "power", "whole")] == [
        "a.p <-> b.p", "b (the sum of c, d)", "a", "power over a.p <-> b.p", exact + 0.02
    ]  # fmt: skip
    assert "up to 1 % of the energy exchanged" in flows["rows"]  # 0.02 of 2 J
    assert "differs by -1 % of the energy exchanged" in flows["balance"]
    assert data_of(page)["samples"]["variables"][-1]["name"] == "power over a.p <-> b.p"
    page = report(tmp_path / "r.html", attributes, a__x=TIME)  # which records neither
    (told,) = data_of(page)["flows"]["flows"]
    assert (told["power"], told["whole"]) == ("", exact + 0.02)


def test_works_of_a_program_flow_into_what_they_move(tmp_path: Path) -> None:
    """A push that gives 3 J, of which 2.9 J are stored: the balance closes to 0.1 of 3 J."""
    rows = {"load.push.work": 0.3, "inputs.work": 0.0, "other.work": 1.0, "energy.kinetic": 0.29,
            "energy.potential": 0.0, "energy.total": 0.29}  # fmt: skip
    values = {f"cart.{name}": rate * TIME for name, rate in rows.items()}
    made = results_of(TIME, values, units=dict.fromkeys(values, "J"))
    page = Page(report_of_run(made, tmp_path / "r.html").read_text("utf-8"))
    flows = data_of(page)["flows"]
    assert [(one["source"], one["target"], one["energy"]) for one in flows["flows"]] == [
        ("push", "cart", "cart.load.push.work"),
        ("inputs", "cart", "cart.inputs.work"),
    ]
    assert flows["stored"] == {"cart": "cart.energy.total"}
    for text in (flows["balance"], page.text):
        assert "closes to 3.3e+00 % of the largest energy exchanged, 3 J" in text


def test_texts_of_others_are_shown_and_do_nothing(tmp_path: Path) -> None:
    record = Record(
        graph=Graph(HOSTILE, HOSTILE, (GraphComponent(HOSTILE, HOSTILE),), ()),
        flows=(Flow(HOSTILE, HOSTILE, "b", ()),),
        inputs=(InputFile(HOSTILE, HOSTILE, HOSTILE),),
        fmus={HOSTILE: HOSTILE},
        versions={HOSTILE: HOSTILE},
    )
    end = RecordEnd(errors=(StatedError(HOSTILE, HOSTILE, 1.0, 1.0, 1.0, HOSTILE),))
    names = ("title", "comment", "algorithm", "notes", "messages", "scenario", "ended", "changed",
             "start_values", "coupling_error")  # fmt: skip
    attributes = {
        **dict.fromkeys(names, HOSTILE), **carried_record(record), **carried_record(end)
    }  # fmt: skip
    series = {f"{HOSTILE}.{HOSTILE}": TIME}
    made = results_of(TIME, series, units=dict.fromkeys(series, HOSTILE), attributes=attributes)
    path = report_of_run(made, tmp_path / "r.html", command=HOSTILE)
    page = Page(path.read_text("utf-8"))
    pictures = [given for tag, given in page.tags if tag == "img"]
    assert [str(given["src"])[:26] for given in pictures] == ["data:image/svg+xml;base64,"]
    plain = report(tmp_path / "p.html", {}, a__x=TIME)
    scripts = [sum(tag == "script" for tag, _ in one.tags) for one in (page, plain)]
    assert scripts[0] == scripts[1]
    assert html.unescape(page.text).count(HOSTILE) >= len(names) + 8


def test_results_that_show_nothing_are_refused(tmp_path: Path) -> None:
    many = results_of(TIME, {f"a.x{k}": TIME for k in range(2)})
    for made, said in (
        (results_of(TIME[:1], {"a.x": TIME[:1]}), "it has one row"),
        (results_of(TIME, {"a.x": TIME}, attributes={"scene": "x"}), r"made\.nc: .*scene"),
        (
            replace(many, time=np.lib.stride_tricks.as_strided(TIME, (40_000_000,), (0,))),
            "it has 80,000,000 numbers; .* 60,000,000",
        ),
    ):
        with pytest.raises(InputError, match=said):
            report_of_run(made, tmp_path / "r.html")
    assert list(tmp_path.iterdir()) == []
    assert data_of(report(tmp_path / "r.html", {}))["first"] == []  # nothing but the time


RECORD = Record(
    graph=Graph(
        "a system", "jacobi",
        (GraphComponent("a", "a.fmu"), GraphComponent("b", "1 input unconnected", looped=True)),
        (Arrow("a", "b", "x, vx", timing="KNOWN"), Arrow("b", "a", "y", once=True)),
        {"KNOWN": "in time"},
    ),
    flows=(Flow("a.p <-> b.p", "a", "b", (Product("a.p.force_x", "b.p.vx", 1e3),), ("c", "d")),),
    inputs=(InputFile("s.yaml", "ab", "name: </script>\n"), InputFile("big.nc", "cd", None)),
    fmus={"a": "a.fmu, SHA-256 0"},
    versions={"Python": "3.11"},
)  # fmt: skip


def test_damaged_records_are_refused() -> None:
    """Odd texts, every cut of one, and graphs without the ends of their arrows."""
    text = carried_record(RECORD)[ATTRIBUTE]
    texts = ["[]", '{"graph": 3}', '{"flows": [{"connection": 1}]}', "[" * 100_000, "\ud800"]
    graphs = (
        Graph("none", "jacobi", (), ()),
        Graph("twice", "jacobi", (GraphComponent("a", ""), GraphComponent("a", "")), ()),
        Graph("loose", "jacobi", (GraphComponent("a", ""),), (Arrow("a", "b", "x"),)),
    )
    texts += [text[:length] for length in range(0, len(text), 17)]
    texts += [carried_record(Record(graph=graph))[ATTRIBUTE] for graph in graphs]
    for damaged in texts:
        with pytest.raises(InputError, match=r"r\.nc: its record is damaged"):
            record_of({ATTRIBUTE: damaged}, "r.nc")
