"""Comparison of two records of the same quantities: `compare`.

`alignment` brings both to the same times, `measures` says how far they are apart, `matching` which
variables belong together. Start with `comparing`.
"""

from m4e_fmi.analysis.comparison.comparing import compare
from m4e_fmi.analysis.comparison.differences import Comparison, Difference

__all__ = [
    "Comparison",
    "Difference",
    "compare",
]
