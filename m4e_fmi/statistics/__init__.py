"""Statistics of records: arrays in, arrays out.

`STATISTICS` has them by name, each a `Statistic` with its unit and parameters. What is not defined
for a record is nan, with the reason. Start with `statistic`, then the module of the kernel.
"""

from m4e_fmi.statistics.confidence import Interval, confidence_interval
from m4e_fmi.statistics.cycles import Peaks, exceedance_curve, peaks
from m4e_fmi.statistics.extremes import (
    Extreme,
    gaussian_extreme,
    gumbel_extreme,
    weibull_extreme,
)
from m4e_fmi.statistics.rainflow_counting import Rainflow, rainflow_cycles
from m4e_fmi.statistics.spectra import Spectrum, spectrum
from m4e_fmi.statistics.statistic import STATISTICS, Explained, Statistic

__all__ = [
    "STATISTICS",
    "Explained",
    "Extreme",
    "Interval",
    "Peaks",
    "Rainflow",
    "Spectrum",
    "Statistic",
    "confidence_interval",
    "exceedance_curve",
    "gaussian_extreme",
    "gumbel_extreme",
    "peaks",
    "rainflow_cycles",
    "spectrum",
    "weibull_extreme",
]
