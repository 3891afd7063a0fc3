"""Reports of results as text: sections, figures, refusals, and texts that others have made."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.reports import results_of

from m4e_fmi.cosim import Series
from m4e_fmi.errors import InputError
from m4e_fmi.report import report_of_run
from m4e_fmi.report.graph import Arrow, Component, Graph
from m4e_fmi.report.run_report.record import (
    Flow,
    FlowEnergy,
    InputFile,
    Product,
    Record,
    RecordEnd,
    StatedError,
    carried_record,
)
from m4e_fmi.results.recorded import TEXT, Recorded
from m4e_fmi.results.row_header import NOT_ENDED

TIME = np.linspace(0.0, 10.0, 101)
HOSTILE = "</script><img src=x onerror=alert(1)>&%{y}\"'$x^$"


class Parts(HTMLParser):
    """Tags of a page with their attributes, and its texts outside scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self.text = ""
        self._inside = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self._inside = tag
            self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        self._inside = "" if tag == self._inside else self._inside

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.scripts[-1] += data
        else:
            self.text += data


def report(path: Path, attributes: Mapping[str, str], **values: np.ndarray) -> Parts:
    named = {name.replace("__", "."): one for name, one in values.items()}
    made = results_of(TIME, named, units=dict.fromkeys(named, "N"), attributes=attributes)
    return Parts(report_of_run(made, path).read_text("utf-8"))


def data_of(page: Parts) -> dict[str, Any]:
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
        "warning: another", "fmu: beware", "The run ended early: failed: nan.", "2.0e-03",
        "0.005 N", "0 to 10 s, 101 rows",
    ):  # fmt: skip
        assert text in page.text
    (variable,) = data_of(page)["samples"]["variables"]
    assert variable["stated"] == "2.0e-03 of range, 0.005 N"


def test_a_killed_run_and_a_wide_graph(tmp_path: Path) -> None:
    """The run has not ended; a graph of many parts is scrolled, not shrunk until it is a line."""
    names = [f"{kind}{k}" for k in range(30) for kind in "ab"]
    arrows = tuple(Arrow(f"a{k}", f"b{k}", "") for k in range(30))
    graph = Graph("many", "jacobi", tuple(Component(name, "") for name in names), arrows)
    attributes = {"ended": NOT_ENDED, "step_size": "0.1 s", **carried_record(Record(graph=graph))}
    path = tmp_path / "r.html"
    page = report(path, attributes, a__x=np.sin(TIME))
    assert "The run has not ended yet: the run goes on, or its process was killed." in page.text
    assert "0.1 s each" in page.text
    assert '<img class="picture large"' in path.read_text("utf-8")


def test_powers_over_connections_are_forces_times_velocities(tmp_path: Path) -> None:
    force, velocity = np.cos(TIME), np.sin(TIME) ** 2
    product = Product("b.p.force_x", "a.p.vx", 2.0)
    flow = Flow("a.p <-> b.p", "b", "a", (product,), ("c", "d"))
    exact = float(np.trapezoid(2 * force * velocity, TIME))
    ends = RecordEnd(energies=(FlowEnergy(exact + 0.02, exact, 2.0),))
    attributes = {**carried_record(Record(flows=(flow,))), **carried_record(ends)}
    page = report(tmp_path / "r.html", attributes, b__p__force_x=force, a__p__vx=velocity)
    flows = data_of(page)["flows"]
    assert flows["flows"] == [
        {
            "name": "a.p <-> b.p",
            "source": "b (the sum of c, d)",
            "target": "a",
            "power": "power over a.p <-> b.p",
            "whole": exact + 0.02,
        }
    ]
    assert "up to 1 % of the energy exchanged" in flows["rows"]  # 0.02 of 2 J
    assert "differs by -1 % of the energy exchanged" in flows["balance"]
    assert data_of(page)["samples"]["variables"][-1]["name"] == "power over a.p <-> b.p"


def test_a_connection_that_was_not_recorded_has_its_energy_only(tmp_path: Path) -> None:
    flow = Flow("a.p <-> b.p", "b", "a", (Product("b.force_x", "a.vx", 1.0),))
    attributes = {
        **carried_record(Record(flows=(flow,))),
        **carried_record(RecordEnd(energies=(FlowEnergy(3.0, 3.0, 3.0),))),
    }
    page = report(tmp_path / "r.html", attributes, a__x=TIME)
    (told,) = data_of(page)["flows"]["flows"]
    assert (told["power"], told["whole"]) == ("", 3.0)


def test_works_of_a_program_flow_into_what_they_move(tmp_path: Path) -> None:
    """A push that gives 3 J, of which 2.9 J are stored: the balance closes to 0.1 of 3 J."""
    work, total = 0.3 * TIME, 0.29 * TIME
    values = {"cart.load.push.work": work, "cart.inputs.work": 0 * TIME, "cart.other.work": TIME,
              "cart.energy.kinetic": total, "cart.energy.potential": 0 * TIME,
              "cart.energy.total": total}  # fmt: skip
    made = results_of(TIME, values, units=dict.fromkeys(values, "J"))
    page = Parts(report_of_run(made, tmp_path / "r.html").read_text("utf-8"))
    flows = data_of(page)["flows"]
    assert [(one["source"], one["target"], one["energy"]) for one in flows["flows"]] == [
        ("push", "cart", "cart.load.push.work"),
        ("inputs", "cart", "cart.inputs.work"),
    ]
    assert flows["stored"] == {"cart": "cart.energy.total"}
    assert "closes to 3.3e+00 % of 3 J" in flows["balance"]
    assert "closes to 3.3e+00 % of 3 J" in page.text


def test_texts_of_others_are_shown_and_do_nothing(tmp_path: Path) -> None:
    record = Record(
        graph=Graph(HOSTILE, HOSTILE, (Component(HOSTILE, HOSTILE),), ()),
        flows=(Flow(HOSTILE, HOSTILE, "b", ()),),
        inputs=(InputFile(HOSTILE, HOSTILE, HOSTILE),),
        fmus={HOSTILE: HOSTILE},
        seeds={HOSTILE: HOSTILE},
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
    path = report_of_run(made, tmp_path / "r.html", printed=HOSTILE, command=HOSTILE)
    page = Parts(path.read_text("utf-8"))
    pictures = [given for tag, given in page.tags if tag == "img"]
    assert [str(given["src"])[:26] for given in pictures] == ["data:image/svg+xml;base64,"]
    assert not any(name.startswith("on") for _, given in page.tags for name in given)
    plain = report(tmp_path / "p.html", {}, a__x=TIME)
    scripts = [sum(tag == "script" for tag, _ in one.tags) for one in (page, plain)]
    assert scripts[0] == scripts[1]
    assert html.unescape(page.text).count(HOSTILE) >= len(names) + 8


def test_a_page_asks_for_nothing(tmp_path: Path) -> None:
    page = report(tmp_path / "r.html", {}, a__x=TIME)
    (policy,) = [given["content"] for tag, given in page.tags if "http-equiv" in given]
    assert str(policy).startswith("default-src 'none';")
    assert not [given for _, given in page.tags if str(given.get("src", "data:"))[:5] != "data:"]
    links = [str(given["href"]) for _, given in page.tags if "href" in given]
    assert links
    assert all(link.startswith("#") for link in links)
    assert not re.search(r"https?://(?!www\.w3\.org)", "".join(page.scripts[-1:]))


def test_results_that_show_nothing_are_refused(tmp_path: Path) -> None:
    one = results_of(TIME[:1], {"a.x": TIME[:1]})
    with pytest.raises(InputError, match="it has one row"):
        report_of_run(one, tmp_path / "r.html")
    with pytest.raises(InputError, match=r"cannot be written as '\.pdf'"):
        report_of_run(one, tmp_path / "r.pdf")
    damaged = results_of(TIME, {"a.x": TIME}, attributes={"record": "{"})
    with pytest.raises(InputError, match=r"made\.nc: its record of the run is damaged"):
        report_of_run(damaged, tmp_path / "r.html")
    scene = results_of(TIME, {"a.x": TIME}, attributes={"scene": "x"})
    with pytest.raises(InputError, match=r"made\.nc: .*scene"):
        report_of_run(scene, tmp_path / "r.html")
    assert list(tmp_path.iterdir()) == []


def test_results_of_nothing_but_the_time_and_of_texts(tmp_path: Path) -> None:
    assert data_of(report(tmp_path / "r.html", {}))["first"] == []
    text = Series("x", "", "", np.array(["a"] * 101, object), Recorded("String", TEXT))
    made = results_of(TIME, {})
    made = replace(made, components={"a": {"x": text}})
    flow = Flow("a <-> b", "a", "b", (Product("a.x", "a.x", 1.0),))
    made = replace(made, attributes=carried_record(Record(flows=(flow,))))
    page = Parts(report_of_run(made, tmp_path / "r.html").read_text("utf-8"))
    assert "Texts are in the results only: a.x." in page.text
    assert data_of(page)["flows"]["flows"][0]["power"] == ""


def test_too_many_numbers_are_refused_before_any_work(tmp_path: Path) -> None:
    many = np.broadcast_to(TIME, (101,))
    made = results_of(TIME, {f"a.x{k}": many for k in range(2)})
    huge = replace(made, time=np.lib.stride_tricks.as_strided(TIME, (40_000_000,), (0,)))
    with pytest.raises(InputError, match=r"it has 80,000,000 numbers; .* 60,000,000"):
        report_of_run(huge, tmp_path / "r.html")


def test_a_report_of_noise_stays_below_25_mb(tmp_path: Path) -> None:
    """1e5 rows of 30 variables, which do not compress; every sample is inside."""
    time, random = 0.05 * np.arange(100_000), np.random.default_rng(1)
    values = {f"noise.n{k}": random.normal(size=100_000) for k in range(30)}
    path = report_of_run(results_of(time, values), tmp_path / "r.html")
    assert path.stat().st_size <= 25e6
    page = Parts(path.read_text("utf-8"))
    samples = data_of(page)["samples"]
    assert samples["count"] == 100_000
    assert [one["kind"] for one in samples["variables"]] == 30 * ["f4"]
