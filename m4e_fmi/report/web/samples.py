"""Samples of results as texts inside a page: compressed, one block for each variable.

Numbers are stored byte by byte, first those of the sign and exponent of all, which compresses by a
third; then gzip and base64. `samples.js` reads them.
"""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

MOST_EXACT = 2_000_000
"""Bytes of all samples as Float64 up to which they are stored so; larger ones are Float32."""
LARGEST, SMALLEST = float(np.finfo(np.float32).max), float(np.finfo(np.float32).tiny)
"""Magnitudes that Float32 has; variables with others stay Float64."""


@dataclass(frozen=True)
class Curve:
    """A variable of a page: `values` (n,) in its `unit`, shown as `label` under its `component`.

    `steps` between values rather than lines; `items` are names of values; `stated` is its error.
    """

    name: str
    component: str
    label: str
    unit: str
    description: str
    values: np.ndarray = field(repr=False)
    steps: bool = False
    items: Mapping[str, int] = field(default_factory=dict)
    stated: str = ""


@dataclass(frozen=True)
class Samples:
    """All samples of a page: `data` for `storeOf`, and texts of blocks by their ids.

    `exact` is False if most are rounded to Float32.
    """

    data: dict[str, object]
    blocks: dict[str, str]
    exact: bool


def packed_samples(
    time: NDArray[np.float64], curves: Iterable[Curve], *, prefix: str = ""
) -> Samples:
    """Every sample of `curves` at `time` (n,) [s], times exactly.

    Ids of blocks begin with `prefix`, which keeps several sets of samples apart in one page.
    """
    curves = list(curves)
    exact = 8 * len(time) * len(curves) <= MOST_EXACT
    blocks: dict[str, str] = {}
    when = _stored(np.asarray(time, float), True, f"{prefix}time", blocks)
    variables = []
    for number, curve in enumerate(curves):
        stored = _stored(curve.values, exact, f"{prefix}v{number}", blocks)
        variables.append({**dict(_described(curve)), **stored})
    return Samples({"count": len(time), "time": when, "variables": variables}, blocks, exact)


def block(data: bytes) -> str:
    """Bytes as a block of a page."""
    return base64.b64encode(gzip.compress(data, 6, mtime=0)).decode("ascii")


def _described(curve: Curve) -> Iterator[tuple[str, object]]:
    yield from (("name", curve.name), ("component", curve.component), ("label", curve.label))
    yield from (("unit", curve.unit), ("description", curve.description))
    finite = curve.values[np.isfinite(curve.values)].astype(float)
    yield "low", float(finite.min()) if len(finite) else 0.0
    yield "high", float(finite.max()) if len(finite) else 0.0
    if curve.steps:
        yield "steps", True
    if curve.items:
        yield "items", dict(curve.items)
    if curve.stated:
        yield "stated", curve.stated


def _stored(
    values: np.ndarray, exact: bool, name: str, blocks: dict[str, str]
) -> dict[str, object]:
    """How the page has `values` (n,), in their unit; adds the block `name` if they vary."""
    if len(values) and np.isfinite(values[0]) and (values == values[0]).all():
        return {"constant": float(values[0])}
    kind = "u1" if values.dtype == bool else "f8" if exact or not _fits(values) else "f4"
    stored = np.ascontiguousarray(values.astype(f"<{kind}"))
    apart = stored.view(np.uint8).reshape(len(stored), stored.itemsize).T
    blocks[name] = block(apart.tobytes())
    return {"block": name, "kind": kind}


def _fits(values: np.ndarray) -> bool:
    """True if rounding `values` (n,) to Float32 leaves each its first seven digits."""
    if values.dtype.kind != "f":
        return bool((values.astype(np.float32) == values).all())
    sizes = np.abs(values[np.isfinite(values) & (values != 0.0)])
    return not len(sizes) or bool(sizes.max() < LARGEST and sizes.min() > SMALLEST)
