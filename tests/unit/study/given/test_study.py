"""Reading study files: all problems together, each at its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.study.load import load_study

WRONG = """\
name: wrong
systm: system.yaml
vary: {x: [1, 2]}
wanted:
  a: {variable: x, statistic: meen}
  b: {variable: x, statistic: percentile}
  c: {variable: x, statistic: mean, level: 3}
start_up: -1
"""


def test_all_problems_of_a_file_come_together(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(WRONG, "utf-8")
    with pytest.raises(InputError) as caught:
        load_study(tmp_path / "s.yaml")
    assert [p.line for p in caught.value.problems] == [1, 2, 5, 6, 7, 8]
    for text in ("'system'", "'mean'", "needs the parameter 'percent'", "below 0"):
        assert text in str(caught.value)
