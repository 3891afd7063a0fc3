"""The stated coupling error beside a sampled controller that switches."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import CouplingErrorReport, Outcome, load_system, run

PARTS = {
    "mass.py": """\
class Mass:
    states = {"x": (1.0, "m"), "v": (0.0, "m/s")}
    inputs = {"spring.force": "N", "brake": "N.s/m"}
    outputs = {"spring.place": "m", "speed": "m/s"}

    def rates(self, t, v):
        return {"x": v.v, "v": v.spring.force - v.brake * v.v + math.cos(0.7 * t)}

    def calculate(self, t, v):
        return {"spring.place": v.x, "speed": v.v}
""",
    "spring.py": """\
class Spring:
    inputs = {"mass.place": "m"}
    outputs = {"mass.force": "N"}

    def calculate(self, t, v):
        return {"mass.force": -v.mass.place}
""",
    "latch.py": """\
class Latch:
    inputs = {"speed": "m/s"}
    outputs = {"brake": "N.s/m"}

    def start(self, v):
        self.until, self.last = -1.0, 0.0
        return {"brake": 0.1}

    def step(self, t, h, v):
        if t >= self.until and self.last * v.speed < 0:
            self.until = t + 0.95
        self.last = v.speed if t >= self.until else 0.0
        return {"brake": 20.0 if t < self.until else 0.1}
""",
}
SYSTEM = """\
name: latched
components:
  mass: {kind: python, file: mass.py}
  spring: {kind: python, file: spring.py}
  latch: {kind: python, file: latch.py, step_size: 0.2}
connections:
  - mass.spring.place -> spring.mass.place
  - spring.mass.force -> mass.spring.force
  - mass.speed -> latch.speed
  - latch.brake -> mass.brake
simulation: {stop_time: 60, step_size: 0.1, algorithm: gauss_seidel}
"""


def latched(folder: Path, step_size: float) -> Outcome:
    for name, text in PARTS.items():
        head = "import math\n\n\n" if "math." in text else ""
        (folder / name).write_text(head + text, encoding="utf-8")
    (folder / "system.yaml").write_text(SYSTEM, encoding="utf-8")
    system = load_system(folder / "system.yaml").changed(step_size=step_size)
    return run(system, results=folder / f"{step_size}.nc", build_directory=folder / "build")


@pytest.mark.verifies(
    "coupling error stated of a latched mass, beside a sampled controller that switches elsewhere: "
    "true error at most",
    independent="sixteen times finer steps",
    tolerance="3 times the stated error",
)
def test_the_motion_is_told_apart_from_what_switches(tmp_path: Path) -> None:
    """The brake of the coarse run acts one sample later at times, so that its difference is all of
    its range, while the place is right to 2 %."""
    outcome, fine = latched(tmp_path, 0.1), latched(tmp_path, 0.1 / 16).results()
    found, report = outcome.results(), outcome.certificate
    assert isinstance(report, CouplingErrorReport)
    rows = np.searchsorted(fine.time, found.time - 1e-9)
    differences = {
        str(one.source): np.abs(
            np.asarray(found[str(one.source)]) - np.asarray(fine[str(one.source)])[rows]
        )
        / one.span
        for one in report.errors
    }
    (latch,) = (one for one in report.errors if one.switched)
    assert str(latch.source) == "latch.brake"
    for one in report.errors:
        if not one.switched:
            assert differences[str(one.source)].max() < 3.0 * one.error
    apart = differences["latch.brake"] > 0.5
    assert apart.any()
    # no switch is off by more than one sample, two steps
    assert not (apart[2:] & apart[1:-1] & apart[:-2]).any()
    assert not any("unusable" in line for line in outcome.warnings)
    assert "latch.brake switches a step earlier or later" in str(report)
