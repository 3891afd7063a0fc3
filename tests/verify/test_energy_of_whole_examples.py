"""The balance of energy over the whole runs of examples/, with their own meshes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from support.energy_lines import LIMIT, energy_lines
from support.example_systems import EXAMPLES, example_files, hydraulic_kinds

from m4e_fmi.cosim import load_system


@pytest.fixture(scope="module", autouse=True)
def _kinds(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with hydraulic_kinds(tmp_path_factory.mktemp("site")):
        yield


@pytest.mark.parametrize("name", example_files("system*.yaml"))
def test_whole_runs(name: str, tmp_path: Path) -> None:
    lines = energy_lines(load_system(EXAMPLES / name), tmp_path)
    residual = np.abs(lines.residual).max() / lines.gross
    coupling = lines.coupling / lines.gross
    print(f"{name}: {lines.gross:.3g} J, residual {residual:.1e}, coupling {coupling:.1e}")
    assert residual < LIMIT
    assert coupling < LIMIT
