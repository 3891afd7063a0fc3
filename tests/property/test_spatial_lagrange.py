"""Small trees in space against Lagrange's equations; make verify has more of them."""

from __future__ import annotations

import pytest
from support.spatial_lagrange import check_tree


@pytest.mark.verifies(
    "accelerations of small trees in space", independent="SymPy's derivatives, Lagrange",
    tolerance="1e-10",
)  # fmt: skip
@pytest.mark.parametrize("seed", [0, 2])
def test_trees(seed: int) -> None:
    check_tree(seed)
