"""Algebraic loops without a single solution, which zeros solve, too."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from m4e_fmi.cosim import load_system, run
from m4e_fmi.errors import RunError

TWO = """\
name: two
components:
  a: {{fmu: {fmu}, start: {{gain: {a}}}}}
  b: {{fmu: {fmu}, start: {{gain: {b}}}}}
connections: [a.y -> b.u, b.y -> a.u]
simulation: {{stop_time: 0.3, step_size: 0.1}}
"""


@pytest.mark.parametrize("model", ["stage", "stage+jacobian"])
@pytest.mark.parametrize(
    ("a", "b", "singular"),
    [(1.0, 1.0, True), (3.0, 1.0 / 3.0, True), (1e6, 1e-6, True), (-1.0, 1.0, False),
     (1.001, 1.0, False), (1e6, -1e-6, False)],
)  # fmt: skip
def test_a_loop_with_the_gain_1_is_refused(
    c_fmu: Callable[[str], Path], tmp_path: Path, model: str, a: float, b: float, singular: bool
) -> None:
    path = tmp_path / "system.yaml"
    path.write_text(TWO.format(fmu=c_fmu(model), a=a, b=b), encoding="utf-8")
    given, results = load_system(path), tmp_path / "r.nc"
    if not singular:
        run(given, results=results, build_directory=tmp_path)
        return
    with pytest.raises(RunError, match=r"the algebraic loop of .* is singular at t = 0 s"):
        run(given, results=results, build_directory=tmp_path)
