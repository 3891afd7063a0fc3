"""Sections of a study file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, StringConstraints

from m4e_fmi.cosim.system.simulation import Time
from m4e_fmi.files.document import Section

Scalar = bool | int | float | str
Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_]\w*$")]
"""A name of a dimension or a variable of the result."""
MOST_POINTS = 1_000_000
"""Of one dimension, and of all together."""


class AxisSection(Section):
    """Values of one quantity, or of several that move together.

    `from` and `to` with `step` or `count`, or a list of `values`, or the first so many `seeds`:
    1, 2, 3, … The same values are those of all `names`, if there are any. `together` has a list
    for each of several names, of one length. `as` is the name of the dimension.
    """

    values: tuple[Scalar, ...] | None = None
    from_: float | None = Field(default=None, alias="from")
    to: float | None = None
    step: float | None = None
    count: int | None = Field(default=None, ge=1, le=MOST_POINTS)
    seeds: int | None = Field(default=None, ge=1, le=MOST_POINTS)
    together: dict[str, tuple[Scalar, ...]] | None = None
    names: tuple[str, ...] | None = None
    as_: Name | None = Field(default=None, alias="as")


class Spread(Section):
    """A distribution of a sampled quantity.

    `uniform` and `log_uniform` lie between `low` and `high`; `normal` and `log_normal` have the
    `mean` and `standard_deviation` of the quantity itself.
    """

    distribution: Literal["uniform", "log_uniform", "normal", "log_normal"]
    low: float | None = None
    high: float | None = None
    mean: float | None = None
    standard_deviation: float | None = None


class SampleSection(Section):
    """`count` points that fill the space of the quantities `of`; the same for a `seed`."""

    method: Literal["latin_hypercube", "sobol"]
    count: int = Field(ge=1, le=MOST_POINTS)
    seed: int = Field(default=0, ge=0)
    of: dict[str, tuple[float, float] | Spread]


class TableSection(Section):
    """Rows of a table (CSV): one case each. `columns` maps names to columns, as does `weight`.

    Rows of weight 0 are run with `run_all` only.
    """

    file: str
    columns: dict[str, str]
    weight: str | None = None
    run_all: bool = False


class ScatterSection(Section):
    """A scatter diagram (CSV): the first row and the first column have the values of two names.

    Entries are occurrences or probabilities; those without any are run with `run_all` only. `total`
    is what they would add up to if they covered all the time, as 8766 of hours of a year; default
    is their sum.
    """

    file: str
    rows: str
    columns: str
    total: float | None = Field(default=None, gt=0.0)
    run_all: bool = False


class WantedSection(Section):
    """A statistic of a variable; further keys are its parameters, as ``percent: 95``."""

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True)

    variable: str
    statistic: str


class StudySection(Section):
    """A study file."""

    name: str
    description: str = ""
    system: str | None = None
    model: str | None = None
    method: Literal["cosimulated", "composed"] = "cosimulated"
    simulation: dict[str, Scalar] = Field(default_factory=dict)
    start: dict[str, Scalar] = Field(default_factory=dict)
    vary: dict[str, AxisSection | tuple[Scalar, ...]] = Field(default_factory=dict)
    sample: SampleSection | None = None
    table: TableSection | None = None
    scatter: ScatterSection | None = None
    wanted: dict[Name, WantedSection] = Field(default_factory=dict)
    series: tuple[str, ...] = ()
    start_up: Time | None = None
    coupling_error: bool = True
