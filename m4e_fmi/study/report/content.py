"""The numbers of a study as the scripts of its page take them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_fmi.report.web.samples import Curve, Samples, packed_samples
from m4e_fmi.study.given.grid import Axis
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.report.annual import Contribution
from m4e_fmi.study.report.result import StudyResult

MEAN, WIDTH, MISSING = "mean ", "width ", "missing "
"""Beginnings of the names of numbers of designs."""
VARIED, WANTED, RUN = "varied", "wanted", "run"
"""Components under which numbers of runs are listed."""
TEXTS = {
    "coupling_error": "largest estimated coupling error, of the range",
    "wall_time": "time that the run took",
    "start_up": "rows from this time on count in statistics",
    "wave_power": "power of the waves per metre of crest",
}


@dataclass(frozen=True)
class Content:
    """Numbers of a page: `data` for `studyOf`, and texts of blocks by their ids."""

    data: dict[str, object]
    blocks: dict[str, str]
    exact: bool


def content_of(result: StudyResult, contributed: list[Contribution]) -> Content:
    """All numbers of runs and designs, and the series that a page takes."""
    grid = result.grid
    runs = _packed(list(_of_runs(result)), grid.size, "r")
    designs = _packed(list(_of_designs(result, contributed)), 0, "d")
    series = _series(result)
    data: dict[str, object] = {
        "dims": [_dimension(one, result) for one in grid.axes],
        "quantities": [
            {"name": name, "unit": result.units[name], "text": text, "of": ""}
            for name, text in result.quantities.items()
        ]
        + [
            {"name": one.name, "unit": one.unit, "text": one.text, "of": one.of}
            for one in contributed
        ],
        "columns": [
            {"name": varied.name, "dim": number}
            for number, one in enumerate(grid.axes)
            for varied in one.varied
        ],
        "runs": runs.data,
        "designs": designs.data,
        "failures": _failures(result),
        "notRun": np.flatnonzero(~grid.is_run).tolist(),
        "series": series and {
            "samples": series.data,
            "runs": result.series.runs.tolist() if result.series else [],
            "names": list(result.series.values) if result.series else [],
        },
        "startUp": float(np.nanmax(result.numbers["start_up"])),
    }  # fmt: skip
    blocks = {**runs.blocks, **designs.blocks, **(series.blocks if series else {})}
    return Content(data, blocks, runs.exact and designs.exact)


def _packed(curves: list[Curve], count: int, prefix: str) -> Samples:
    """Columns of equal length, in a store whose times are their numbers."""
    count = len(curves[0].values) if curves else count
    return packed_samples(np.arange(count, dtype=float), curves, prefix=prefix)


def _dimension(one: Axis, result: StudyResult) -> dict[str, object]:
    """A dimension of the page; a state if its points have probabilities."""
    alone, values = len(one.varied) == 1, [point[0] for point in one.points]
    numbers = one.is_numbers and bool(np.isfinite(np.array(values, float)).all())
    unit, text = result.labels[one.varied[0].name] if alone else ("", "")
    return {
        "name": one.name,
        "unit": unit,
        "text": text,
        "count": len(one),
        "labels": one.labels if alone else None,
        "numbers": [float(value) for value in values] if numbers else None,
        "repeats": one.repeats,
        "state": bool(result.states and one.name in result.states.names),
    }


def _of_runs(result: StudyResult) -> Iterator[Curve]:
    """Varied quantities, and the numbers of each run."""
    shape = result.grid.shape
    for number, one in enumerate(result.grid.axes):
        along = [len(one) if k == number else 1 for k in range(len(shape))]
        for k, varied in enumerate(one.varied):
            values, items = _coded([point[k] for point in one.points])
            spread = np.broadcast_to(values.reshape(along), shape).reshape(-1)
            unit, text = result.labels[varied.name]
            yield Curve(varied.name, VARIED, varied.name, unit, text, spread, items=items)
    for name, values in result.numbers.items():
        if name == "coupling_error" and np.isnan(values).all():
            continue  # of one program
        told = result.quantities.get(name)
        kind, text = (WANTED, told) if told else (RUN, TEXTS[name])
        yield Curve(name, kind, name, result.units[name], text, values.reshape(-1))


def _coded(values: Sequence[Scalar]) -> tuple[np.ndarray, dict[str, int]]:
    """Numbers (n,) [their unit] for `values`, and what they stand for if those are none."""
    if not any(isinstance(value, bool | str) for value in values):
        return np.array(values, float), {}
    items = {name: k for k, name in enumerate(dict.fromkeys(map(str, values)))}
    return np.array([items[str(value)] for value in values], float), items


def _of_designs(result: StudyResult, contributed: list[Contribution]) -> Iterator[Curve]:
    """Means over seeds with their confidence, and contributions of states."""
    if any(one.repeats for one in result.grid.axes):
        for name in result.quantities:
            found, unit = result.designs(name), result.units[name]
            for kind, values in (
                (MEAN, found.mean), (WIDTH, found.half_width), (MISSING, found.missing)
            ):  # fmt: skip
                yield Curve(f"{kind}{name}", WANTED, name, unit, "", values.reshape(-1))
    for one in contributed:
        yield Curve(f"{MEAN}{one.name}", WANTED, one.name, one.unit, "", one.values.reshape(-1))


def _failures(result: StudyResult) -> dict[str, object]:
    """Failed runs by number, each with the number of its reason."""
    reasons, texts = result.failure.reshape(-1), dict[str, int]()
    runs = [[int(run), texts.setdefault(str(reasons[run]), len(texts))] for run in result.failed]
    return {"texts": list(texts), "runs": runs}


def _series(result: StudyResult) -> Samples | None:
    found = result.series
    if found is None:
        return None
    curves = [
        Curve(f"{name}, run {run + 1}", f"run {run + 1}: {result.grid.label(int(run))}", name,
              found.units[name], found.texts[name], found.values[name][row])
        for row, run in enumerate(found.runs.tolist())
        for name in found.values
    ]  # fmt: skip
    return packed_samples(found.time, curves, prefix="s")
