"""Statistics of records: arrays in, arrays out.

`STATISTICS` has them by name, each a `Statistic` with its unit and parameters. What is not defined
for a record is nan, with the reason. Start with `statistic`, then the module of the kernel.
"""

from m4e_fmi.statistics.confidence import Interval, confidence_interval
from m4e_fmi.statistics.cycles import Peaks, peaks
from m4e_fmi.statistics.spectra import Spectrum, spectrum
from m4e_fmi.statistics.statistic import STATISTICS, Explained, Statistic

__all__ = [
    "STATISTICS",
    "Explained",
    "Interval",
    "Peaks",
    "Spectrum",
    "Statistic",
    "confidence_interval",
    "peaks",
    "spectrum",
]
