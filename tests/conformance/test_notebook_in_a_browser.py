"""Tables of objects in a notebook's page: texts are at the left, whatever the page's own rules."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.browser import CHROMIUM, browser

import m4e_fmi as m4e

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")

PENDULUM = Path(__file__).parents[2] / "examples/double_pendulum/double_pendulum.model.yaml"
RULE = ":not(.of-markdown).common td, :not(.of-markdown).common th {text-align: right}"
"""As the pages of JupyterLab and of exported notebooks have it."""


def test_texts_are_at_the_left_and_numbers_at_the_right(tmp_path: Path) -> None:
    shown = m4e.simulate(m4e.load_model(PENDULUM), stop_time=0.1)._repr_html_()
    path = tmp_path / "page.html"
    page_text = f'<meta charset="utf-8"><style>{RULE}</style><div class="common">{shown}</div>'
    path.write_text(page_text, encoding="utf-8")
    with browser(tmp_path / "browser") as page:
        page.open(path)
        sides = page.value(
            "[...document.querySelectorAll('td')].map("
            "e => [e.classList.contains('number'), getComputedStyle(e).textAlign])"
        )
    assert {tuple(side) for side in sides} == {(True, "right"), (False, "left")}
