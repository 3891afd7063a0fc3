"""examples/sphere_decay with coefficients of a file or its own, and limits of its responses."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from support import hemisphere

EXAMPLE = Path(__file__).parents[2] / "examples" / "sphere_decay"
RESPONSE, POWER = 5e-3, 1e-2


def curves(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The script of the example, with coefficients of its own."""
    monkeypatch.syspath_prepend(str(EXAMPLE))
    monkeypatch.delitem(sys.modules, "published_curves", raising=False)
    return importlib.import_module("published_curves")


def example_with_coefficients(
    folder: Path, monkeypatch: pytest.MonkeyPatch, coefficients: Path
) -> ModuleType:
    """The script, whose linear systems in `folder` take their coefficients from a file."""
    for path in EXAMPLE.glob("*.model.yaml"):
        (folder / path.name).write_bytes(path.read_bytes())
    for name in ("system.yaml", "absorber.yaml"):
        lines = (EXAMPLE / name).read_text("utf-8").splitlines()
        (water,) = (k for k, line in enumerate(lines) if line.startswith("    water:"))
        (body,) = (k for k, line in enumerate(lines) if line.startswith("      sphere:"))
        lines[water] = "    water: {density: 1000, depth: 200, gravity: 9.81}"
        lines[body] = f"      sphere: {{}}\n    coefficients: {coefficients}"
        (folder / name).write_text("\n".join([*lines, ""]), "utf-8")
    example = curves(monkeypatch)
    (folder / "published").symlink_to(EXAMPLE / "published")
    monkeypatch.setattr(example, "FOLDER", folder)
    return example


def check_responses(example: ModuleType) -> None:
    """Heave of free and damped sphere within `RESPONSE` of exact theory, at ten periods."""
    _, rows = example.table("heave_responses")
    periods, dampings = rows[:, 0], rows[:, 1]
    for damping in (0.0 * dampings, dampings):
        found = example.responses(periods, damping)
        np.testing.assert_allclose(
            found, hemisphere.heave(2 * np.pi / periods, damping), rtol=RESPONSE
        )


def check_damped_power(example: ModuleType) -> None:
    """Mean power in regular waves within `POWER` of ½ c ω² z²."""
    _, rows = example.table("heave_responses")
    periods, dampings = rows[:, 0], rows[:, 1]
    heights, powers = example.regular_powers(periods, dampings)
    omega = 2 * np.pi / periods
    heave = 0.5 * heights * hemisphere.heave(omega, dampings)
    np.testing.assert_allclose(powers, 0.5 * dampings * (omega * heave) ** 2, rtol=POWER)
