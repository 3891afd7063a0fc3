"""Samples of reports in a real browser: none is lost, spectra are right, names do nothing."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import welch
from support.browser import CHROMIUM, Page
from support.report_pages import opened, settled
from support.reports import results_of

from m4e_fmi.report import report_of_run

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")

HOSTILE = "a<img src=x onerror=alert(1)></script>%{y}$x^$"


def test_no_sample_is_lost_and_a_spike_is_always_seen(page: Page, tmp_path: Path) -> None:
    """One sample of 1e5 stands out; the whole series is drawn on some hundred pixels."""
    time, random = 0.01 * np.arange(100_000), np.random.default_rng(3)
    noise = random.normal(size=100_000)
    noise[[31_234, 80_001]] = 50.0, -70.0
    broken = noise.copy()
    broken[500] = np.nan
    flags = (np.arange(100_000) // 1000 % 2).astype(bool)
    values = {"a.noise": noise, "a.broken": broken, "a.ramp": time**2, "b.flag": flags}
    made = results_of(time, values, units={"a.noise": "m", "a.broken": "s"})
    opened(page, report_of_run(made, tmp_path / "r.html"))
    page.value("report.plots.show('a.noise', -1)")
    settled(page)
    drawn = page.value(
        "report.plots.panels.find(p => p.names.includes('a.noise')).element"
        ".querySelector('.plot').data[0].y"
    )
    assert len(drawn) < 10_000
    assert (max(drawn), min(drawn)) == (50.0, -70.0)
    # the page's own samples: all, rounded to Float32; and what decimation keeps of any part
    count, first, last = page.value(
        "report.store.numbers('a.noise').then(v => [v.length, v[0], v[99999]])"
    )
    assert (count, first, last) == (100_000, np.float32(noise[0]), np.float32(noise[-1]))
    checked = page.value(
        """(async () => {
          const time = report.store.time, wrong = [];
          for (const name of ["a.noise", "a.broken", "a.ramp"]) {
            const values = await report.store.numbers(name);
            for (const [from, to, columns] of [[0, 999.99, 700], [300, 320, 350], [3.3, 900, 13]]) {
              const places = drawn(time, values, from, to, columns), kept = new Set(places);
              const increases = places.every((p, k) => !k || p > places[k - 1]);
              const most = new Map();
              for (let k = 0; k < time.length; k++) {
                if (time[k] < from || time[k] > to || !Number.isFinite(values[k])) continue;
                const c = Math.floor((time[k] - from) / (to - from) * columns), v = values[k];
                const known = most.get(c) || [Infinity, -Infinity, Infinity, -Infinity];
                for (const i of kept.has(k) ? [0, 2] : [0]) {
                  known[i] = Math.min(known[i], v);
                  known[i + 1] = Math.max(known[i + 1], v);
                }
                most.set(c, known);
              }
              const right = [...most.values()].every(([a, b, c, d]) => a === c && b === d);
              if (!right || !increases) wrong.push([name, from, to, columns]);
            }
          }
          return wrong;
        })()"""
    )
    assert checked == []
    assert page.complaints == []


def test_a_break_of_a_curve_is_seen(page: Page, tmp_path: Path) -> None:
    """Where numbers are not finite, one of each column of pixels stays, and the line breaks."""
    time = 0.01 * np.arange(50_000)
    values = np.sin(time)
    values[20_000:20_400] = np.nan
    opened(page, report_of_run(results_of(time, {"a.x": values}), tmp_path / "r.html"))
    y = page.value("document.querySelector('.plot').data[0].y")
    assert None in y
    assert page.complaints == []


def test_spectra_are_those_of_scipy(page: Page, tmp_path: Path) -> None:
    random = np.random.default_rng(5)
    values = np.sin(0.3 * np.arange(5000)) + random.normal(size=5000) + 3.0
    made = results_of(0.2 * np.arange(5000), {"a.x": values})
    opened(page, report_of_run(made, tmp_path / "r.html"))
    text = json.dumps(values.tolist())
    found = page.value(
        f"{{ const s = welch(Float64Array.from({text}), 0.2, segmentOf(5000));"
        "[Array.from(s.frequency), Array.from(s.density), s.segments] }"
    )
    frequency, density = welch(values, 5.0, "hann", nperseg=1024, noverlap=512)
    assert found[2] == 8
    assert found[0] == pytest.approx(frequency)
    assert found[1] == pytest.approx(density, rel=1e-9, abs=1e-12)
    page.value("report.spectra.draw()")
    told = page.value("document.querySelector('.spectra .told').textContent")
    assert "mean of 8 periodograms" in told
    assert page.complaints == []


def test_names_of_others_do_nothing(page: Page, tmp_path: Path) -> None:
    time = np.linspace(0.0, 1.0, 50)
    values = {f"{HOSTILE}.{HOSTILE}": time**2, f"b.{HOSTILE}": time}
    units = dict.fromkeys(values, "<b>m</b>")
    texts = {"title": HOSTILE, "comment": HOSTILE, "notes": HOSTILE}
    made = results_of(time, values, units=units, attributes=texts)
    opened(page, report_of_run(made, tmp_path / "r.html", command=HOSTILE))
    page.value("document.querySelector('.groups details').open = true")
    page.value("report.spectra.draw()")
    page.value("document.querySelector('.plot').scrollIntoView({block: 'center'})")
    box = page.value("{ const r = document.querySelector('.plot').getBoundingClientRect();"
                     "[r.left + r.width / 2, r.top + r.height / 2] }")  # fmt: skip
    page.mouse("mouseMoved", *box)
    settled(page)
    assert page.value("document.querySelectorAll('img').length") == 0
    assert page.value("document.querySelector('h1').textContent") == HOSTILE
    assert page.value("document.querySelector('.hoverlayer').textContent").count("onerror") >= 1
    assert page.value("document.querySelector('.groups li span').textContent") == HOSTILE
    assert page.complaints == []
