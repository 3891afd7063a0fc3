"""The progress bar: on terminals, and nowhere else."""

import io

import pytest

from m4e_fmi.report import progress_bar


@pytest.mark.parametrize("terminal", [True, False])
def test_a_bar_is_drawn_on_terminals_only(monkeypatch: pytest.MonkeyPatch, terminal: bool) -> None:
    error = io.StringIO()
    error.isatty = lambda: terminal  # pyrefly: ignore[method-assign]
    monkeypatch.setattr("sys.stderr", error)
    with progress_bar(2.0) as progress:
        progress(1.0)
        progress(2.0)
    assert ("of 2 s simulated" in error.getvalue()) is terminal
