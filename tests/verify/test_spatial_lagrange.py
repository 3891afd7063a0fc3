"""Trees in space whose equations SymPy derives by Lagrange in half a minute to three."""

from __future__ import annotations

import pytest
from support.spatial_lagrange import check_tree


@pytest.mark.parametrize("seed", [1, 3, 4, 5, 6, 7, 8, 9])
def test_trees(seed: int) -> None:
    check_tree(seed)
