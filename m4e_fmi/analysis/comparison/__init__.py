"""Comparison of two records of the same quantities: `compare`; of tables: `compare_cells`.

`alignment` brings both to the same times, `measures` says how far they are apart, `matching` which
variables belong together; `cells` is for numbers over other dimensions. Start with `comparing`.
"""

from m4e_fmi.analysis.comparison.cells import CellComparison, CellDifference, compare_cells
from m4e_fmi.analysis.comparison.comparing import compare
from m4e_fmi.analysis.comparison.differences import Comparison, Difference

__all__ = [
    "CellComparison",
    "CellDifference",
    "Comparison",
    "Difference",
    "compare",
    "compare_cells",
]
