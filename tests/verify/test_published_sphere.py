"""examples/sphere_decay with its own coefficients, from its shape: limits of the fast tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import hemisphere
from support.published_sphere import check_damped_power, check_responses, curves


def test_decays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Linear ones against exact theory, with hydrostatics of the wetted part against CFD."""
    example = curves(monkeypatch)
    for release in example.RELEASES:
        times, heave = example.linear_decay(release)
        error = np.sqrt(np.mean((heave - release * hemisphere.decay(times)) ** 2)) / release
        print(f"linear, from {release:g} m: {error:.3%} of the release from exact theory")
        assert error < 3e-3
    found = example.picture_of_decays(tmp_path)
    print({release: f"{difference:.3%} from CFD" for release, difference in found.items()})
    assert found[1.0] < 5e-3
    assert found[5.0] < 8e-3


def test_responses_and_powers(monkeypatch: pytest.MonkeyPatch) -> None:
    example = curves(monkeypatch)
    check_responses(example)
    check_damped_power(example)
