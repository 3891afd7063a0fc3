"""The plotting library in pages: without the function around it; another form is left as it is."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from m4e_fmi.report.web.library import plotly_js, unwrapped


def test_the_library_is_no_argument_of_a_function() -> None:
    spec = find_spec("plotly")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    whole = (
        Path(spec.submodule_search_locations[0]) / "package_data" / "plotly.min.js"
    ).read_bytes()
    found = plotly_js()
    assert found.startswith(whole[: whole.index(b"*/") + 2] + b'\n"use strict";var Plotly=(()=>{')
    assert found.endswith(b"window.Plotly = Plotly;\n")
    assert 0 < len(whole) - len(found) < 500  # of its five megabytes


def test_another_form_is_left_as_it_is() -> None:
    for script in (b"", b"/** other */ (() => {})();", b'"use strict";var Plotly=(()=>{'):
        assert unwrapped(script) == script
