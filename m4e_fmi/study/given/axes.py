"""Dimensions of a study: what is varied, and the points along each."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Document, Location
from m4e_fmi.study.given.grid import Axis, Grid, Shares, Varied
from m4e_fmi.study.given.sections import (
    MOST_POINTS,
    AxisSection,
    SampleSection,
    Scalar,
    Spread,
    StudySection,
)
from m4e_fmi.study.given.tables import scatter, table

RESERVED = (
    "time", "row", "failure", "coupling_error", "wall_time", "start_up", "probability", "is_run",
    "wave_power",
)  # fmt: skip
"""Names of the result that no dimension may have."""


def grid_of(section: StudySection, document: Document, problems: list[Problem]) -> Grid:
    """The dimensions of a study file, of which wrong ones are left out; adds to `problems`."""
    axes, all_shares = list[Axis](), list[Shares]()
    covered, folder = "", document.path.parent

    @contextmanager
    def collected() -> Generator[None]:
        try:
            yield
        except InputError as error:
            problems.extend(error.problems)

    for name, given in section.vary.items():
        with collected():
            one = given if isinstance(given, AxisSection) else AxisSection(values=given)
            axes.append(_axis(name, one, ("vary", name), document))
    if section.sample:
        with collected():
            axes.append(_sampled(section.sample, document))
    if given := section.table:
        with collected():
            points, weights, units = table(folder, given, document)
            plain = _varied(given.columns, ("table", "columns"))
            heads = zip(plain, given.columns.values(), units, strict=True)
            varied = tuple(replace(one, column=head, unit=unit) for one, head, unit in heads)
            axes.append(Axis("case", varied, points))
            if weights:
                all_shares.append(Shares(("case",), np.array(weights), "table", given.run_all))
    if given := section.scatter:
        with collected():
            both, shares, covered = scatter(folder, given, document)
            axes += both
            names = given.rows, given.columns
            all_shares.insert(0, Shares(names, shares, "scatter", given.run_all))
    places = [(t, v.location) for axis in axes for v in axis.varied for t in v.targets]
    problems += [
        document.problem(at, f"{name} is varied twice", "leave one out")
        for name, at in _repeated(places)
    ]
    message = "a second dimension of seeds: means over both have no confidence interval"
    remedy = (
        "let them be one dimension, as {seeds: 5, names: [a.seed, b.seed]}, or list the values of "
        "one of them, which is no repeat then"
    )
    problems += [
        document.problem(axis.varied[0].location, message, remedy)
        for axis in [axis for axis in axes if axis.repeats][1:]
    ]
    made = Grid(tuple(axes), tuple(all_shares), covered)
    named = _named(made, {*RESERVED, *section.wanted}, document, problems)
    if named.size > MOST_POINTS:
        message = f"the dimensions have {named.size:,} points together, {MOST_POINTS:,} at most"
        problems.append(document.problem(("name",), message, "vary less, or draw a sample"))
        return Grid(())
    return named


def _named(made: Grid, taken: set[str], document: Document, problems: list[Problem]) -> Grid:
    """The grid with short names, which are none of those `taken`; adds to `problems`."""
    short = _short_names([v.name for axis in made.axes for v in axis.varied], taken)
    named = list[Axis]()
    for axis in made.axes:
        varied = tuple(replace(v, name=short[v.name]) for v in axis.varied)
        name = varied[0].name if axis.name == axis.varied[0].name else axis.name
        named.append(replace(axis, name=_plain(name), varied=varied))
    problems += [
        document.problem(at, f"a dimension or column cannot be called {name!r}",
                         "choose another name with 'as', or in 'wanted'")
        for name, at in _coordinates(named)
        if name in taken
    ]  # fmt: skip
    problems += [
        document.problem(at, f"two dimensions or columns are called {name!r}", "choose with 'as'")
        for name, at in _repeated(_coordinates(named))
    ]
    of_axes = {old.name: new.name for old, new in zip(made.axes, named, strict=True)}
    shares = (replace(one, names=tuple(of_axes[n] for n in one.names)) for one in made.shares)
    return Grid(tuple(named), tuple(shares), made.covered)


def _varied(names: Iterable[str], location: Location) -> tuple[Varied, ...]:
    return tuple(Varied(name, (name,), (*location, name)) for name in names)


def _axis(name: str, given: AxisSection, at: Location, document: Document) -> Axis:
    """The dimension of an entry of `vary`; InputError for a wrong one."""

    def wrong(place: Location, message: str, remedy: str = "") -> InputError:
        return InputError([document.problem(place, message, remedy)])

    known = {
        "values": given.values is not None,
        "from": given.from_ is not None or given.to is not None,
        "seeds": given.seeds is not None,
        "together": given.together is not None,
    }
    ways = [key for key, there in known.items() if there]
    if len(ways) != 1:
        what = f"has {' and '.join(ways)}" if ways else "has no values"
        remedy = "give a list, or one of 'values', 'from' and 'to', 'seeds' and 'together'"
        raise wrong(at, f"{name} {what}", remedy)
    if given.together is not None:
        lengths = {len(values) for values in given.together.values()}
        if len(lengths) != 1 or lengths == {0}:
            message = f"{name}: names that move together need as many values each"
            raise wrong((*at, "together"), message)
        points = tuple(zip(*given.together.values(), strict=True))
        return Axis(given.as_ or name, _varied(given.together, (*at, "together")), points)
    values = _values(name, given, at, document)
    if not values:
        raise wrong(at, f"{name} has no values", "give one at least")
    short = given.as_ or name
    varied = (Varied(short, given.names or (name,), at),)
    points = tuple((value,) for value in values)
    return Axis(short, varied, points, repeats=given.seeds is not None)


def _values(name: str, given: AxisSection, at: Location, document: Document) -> tuple[Scalar, ...]:
    if given.values is not None:
        return given.values
    if given.seeds is not None:
        return tuple(range(1, given.seeds + 1))
    low, high = given.from_, given.to
    if odd := [x for x in (low, high, given.step) if x is not None and not math.isfinite(x)]:
        message = f"{name}: a range of {odd[0]:g}, expected finite numbers"
        raise InputError([document.problem(at, message)])
    both = given.step is not None and given.count is not None
    if low is None or high is None or both or (given.step is None and given.count is None):
        message = f"{name}: a range has 'from', 'to', and either 'step' or 'count'"
        raise InputError([document.problem(at, message, "write {from: 5, to: 12, count: 8}")])
    if given.count == 1 and low != high:
        message = f"{name}: one value cannot be both {low:g} and {high:g}"
        raise InputError([document.problem((*at, "count"), message, "take 2 or more, or a list")])
    if given.count is not None:
        return tuple(np.linspace(low, high, given.count).tolist())
    step = given.step or 0.0
    count = (high - low) / step if step else math.nan
    if not 0.0 <= count < MOST_POINTS:
        message = f"{name}: steps of {step:g} do not lead from {low:g} to {high:g}"
        remedy = f"write step: {-step:g}" if -MOST_POINTS < count < 0.0 else ""
        raise InputError([document.problem((*at, "step"), message, remedy)])
    if abs(count - round(count)) > 1e-9 * max(1.0, count):
        reached = low + math.floor(count) * step
        message = f"{name}: steps of {step:g} from {low:g} do not meet {high:g}"
        remedy = f"write to: {reached:g}, or give a count"
        raise InputError([document.problem((*at, "step"), message, remedy)])
    return tuple(np.linspace(low, high, round(count) + 1).tolist())


def _sampled(given: SampleSection, document: Document) -> Axis:
    """The dimension `sample`; InputError for spreads that are none."""
    from scipy.stats import qmc

    problems = list[Problem]()
    spreads: dict[str, Spread] = {}
    for name, one in given.of.items():
        spread = one
        if not isinstance(spread, Spread):
            spread = Spread(distribution="uniform", low=spread[0], high=spread[1])
        spreads[name] = spread
        if fault := _fault(spread):
            problems.append(document.problem(("sample", "of", name), f"{name}: {fault}"))
    if given.method == "sobol" and given.count & (given.count - 1):
        message = f"count {given.count} is no power of 2: the points of sobol are not balanced"
        remedy = f"take {2 ** (given.count.bit_length() - 1)} or {2 ** given.count.bit_length()}"
        problems.append(document.problem(("sample", "count", "@value"), message, remedy))
    InputError.raise_for(problems)
    kinds = {"latin_hypercube": qmc.LatinHypercube, "sobol": qmc.Sobol}
    shares = kinds[given.method](len(spreads), rng=given.seed).random(given.count)
    columns = [
        _spread(share, spread) for share, spread in zip(shares.T, spreads.values(), strict=True)
    ]
    points = tuple(tuple(row) for row in np.column_stack(columns).tolist())
    return Axis("sample", _varied(spreads, ("sample", "of")), points)


def _fault(spread: Spread) -> str:
    """The fault of a spread in words; empty if it has none."""
    bounded = spread.distribution.endswith("uniform")
    keys = ("low", "high") if bounded else ("mean", "standard_deviation")
    others = ("mean", "standard_deviation") if bounded else ("low", "high")
    if any(getattr(spread, key) is None for key in keys):
        return f"{spread.distribution} needs {keys[0]} and {keys[1]}"
    if any(getattr(spread, key) is not None for key in others):
        return f"{spread.distribution} takes no {others[0]} or {others[1]}"
    first, second = (float(getattr(spread, key)) for key in keys)
    if not (math.isfinite(first) and math.isfinite(second)):
        return "expected finite numbers"
    if bounded and not first < second:
        return f"low {first:g} is not below high {second:g}"
    if not bounded and second <= 0.0:
        return f"standard_deviation {second:g} is not above 0"
    if spread.distribution.startswith("log") and first <= 0.0:
        return f"{keys[0]} {first:g} is not above 0"
    return ""


def _spread(share: np.ndarray, spread: Spread) -> np.ndarray:
    """Values (n,) of a quantity, in its unit, at shares (n,) [1] of its distribution."""
    from scipy.special import ndtri

    if spread.low is not None and spread.high is not None:
        low, high = spread.low, spread.high
        if spread.distribution == "uniform":
            return low + (high - low) * share
        return np.exp(math.log(low) + (math.log(high) - math.log(low)) * share)
    assert spread.mean is not None
    assert spread.standard_deviation is not None
    inside = ndtri(np.clip(share, 1e-16, 1.0 - 1e-16))
    if spread.distribution == "normal":
        return spread.mean + spread.standard_deviation * inside
    variance = math.log1p((spread.standard_deviation / spread.mean) ** 2)
    return np.exp(math.log(spread.mean) - variance / 2 + math.sqrt(variance) * inside)


def _repeated(places: Sequence[tuple[str, Location]]) -> list[tuple[str, Location]]:
    """Names that are there more than once, with their places."""
    counts = Counter(name for name, _ in places)
    return [(name, at) for name, at in places if counts[name] > 1]


def _coordinates(axes: Sequence[Axis]) -> list[tuple[str, Location]]:
    """Names of the coordinates of the result and their places: dimensions, and columns of them."""
    names = [(a.name, a.varied[0].location) for a in axes]
    return names + [(v.name, v.location) for a in axes if len(a.varied) > 1 for v in a.varied]


def _short_names(full: Sequence[str], taken: Collection[str]) -> Mapping[str, str]:
    """For each dotted name the fewest last segments that no other one ends in, and none `taken`."""
    parts = {name: name.split(".") for name in full}
    found = dict[str, str]()
    for name, own in parts.items():
        known = {n: _plain("_".join(own[-n:])) for n in range(1, len(own) + 1)}
        alone = (n for n in known if sum(o[-n:] == own[-n:] for o in parts.values()) == 1)
        found[name] = next((known[n] for n in alone if known[n] not in taken), known[len(own)])
    return found


def _plain(name: str) -> str:
    """`name` with letters, digits and _ only."""
    kept = "".join(c if c.isalnum() or c == "_" else "_" for c in name)
    return kept.strip("_") or "value"
