"""Statistics of records: arrays in, arrays out.

`STATISTICS` has them by name, each a `Statistic` with its unit and parameters. What is not defined
for a record is nan, with the reason. Start with `statistic`, then the module of the kernel.
"""

from m4e_fmi.statistics.statistic import STATISTICS, Explained, Statistic

__all__ = ["STATISTICS", "Explained", "Statistic"]
