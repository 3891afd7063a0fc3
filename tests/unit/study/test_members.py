"""Each kind of study member is asked the same: members of ensembles, simulations, runs of FMUs.

A new kind is tested by its entry in `KINDS`.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.small_study import Here, written_study

import m4e_fmi
from m4e_fmi.study import StudyOutcome, run_study

KINDS = {
    "ensemble": "model: cart.model.yaml\nsimulation: {stop_time: 0.5}",
    "simulations": "model: cart.model.yaml\nsimulation: {stop_time: 0.5, method: rodas}",
    "composed": "system: system.yaml\nmethod: composed\nsimulation: {stop_time: 0.5}",
    "FMUs": "system: system.yaml\nsimulation: {stop_time: 0.5, step_size: 0.01}",
}
NOTES = {"ensemble": "are members of ensembles", "simulations": "the method rodas"}
SYSTEM = """\
name: carts
components: {cart: {model: cart.model.yaml}}
connections: []
simulation: {stop_time: 1, step_size: 0.01}
"""


class Studies:
    """Studies of the cart by one kind of member; `c.` in a text is the cart, where it is a part."""

    def __init__(self, kind: str, folder: Path, build: Path) -> None:
        self.kind, self.folder, self.build = kind, folder, build
        self.cart = "cart." if "system:" in KINDS[kind] else ""
        self.warned = list[str]()
        self.progress = list[tuple[int, int]]()

    def __call__(
        self,
        varied: str = "c.k: [30, 50], c.joint.hinge.q: [0.1, 0.5]",
        more: str = "start_up: 0.1",
        statistic: str = "maximum",
        fresh: bool = False,
    ) -> StudyOutcome:
        text = (
            f"name: carts\n{KINDS[self.kind]}\nvary: {{{varied}}}\n{more}\nwanted:\n"
            f"  swing: {{variable: c.joint.hinge.q, statistic: {statistic}}}\n"
            "  push: {variable: c.load.spring.effort, statistic: rms}\n"
        )
        (self.folder / "study.yaml").write_text(text.replace("c.", self.cart), "utf-8")
        outcome = run_study(
            self.folder / "study.yaml", build_directory=self.build, executor=Here(),
            tell=self.warned.append, progress=lambda n, of: self.progress.append((n, of)),
            fresh=fresh,
        )  # fmt: skip
        assert NOTES.get(self.kind, "") in "".join(outcome.notes)
        return outcome


@pytest.fixture(params=KINDS)
def study(request: pytest.FixtureRequest, tmp_path: Path) -> Studies:
    written_study(tmp_path, "", system=SYSTEM)
    return Studies(request.param, tmp_path, tmp_path / "build")


def changed_model(folder: Path, old: str, new: str) -> None:
    path = folder / "cart.model.yaml"
    path.write_text(path.read_text("utf-8").replace(old, new, 1), "utf-8")


def test_members_have_the_numbers_of_a_simulation(study: Studies) -> None:
    """The errors of two methods are below their tolerance of 1e-6 times some steps."""
    data = study().data
    model = m4e_fmi.load_model(study.folder / "cart.model.yaml")
    for k, q in ((30.0, 0.1), (50.0, 0.5)):
        start = {"k": k, "joint.hinge.q": q}
        one = m4e_fmi.simulate(model, stop_time=0.5, output_interval=0.01, start_values=start)
        counted = one.time > 0.095
        effort = one["load.spring.effort"].values[counted]
        found = data.sel(k=k, q=q)
        assert float(found["swing"]) == pytest.approx(one["joint.hinge.q"].values[counted].max(),
                                                      rel=1e-4)  # fmt: skip
        mean = np.trapezoid(effort**2, one.time[counted]) / np.ptp(one.time[counted])
        assert float(found["push"]) == pytest.approx(np.sqrt(mean), rel=1e-3)
    assert data["swing"].dims == ("k", "q")
    assert [data[name].attrs["units"] for name in ("swing", "push", "k", "q")] == [
        "rad", "N", "N/m", "rad"
    ]  # fmt: skip


def test_kept_runs_are_those_of_the_same_numbers(study: Studies) -> None:
    first = study()
    assert (first.kept, study().kept) == (0, 4)
    assert study("c.k: [30, 40], c.joint.hinge.q: [0.1, 0.5]").kept == 2
    assert study(statistic="minimum").kept == 0
    changed_model(study.folder, "mass: 2", "mass: 3")
    assert study().kept == 0
    changed_model(study.folder, "mass: 3", "mass: 2")
    fresh = study(fresh=True)
    assert fresh.kept == 0
    for name in ("swing", "push"):
        np.testing.assert_array_equal(fresh.data[name], first.data[name])


def test_a_failed_run_leaves_its_reason_and_no_number(study: Studies) -> None:
    outcome = study("c.k: [30, 50], c.joint.hinge.u: [0, 1.0e+300]")
    assert list(outcome.failures) == [1, 3]
    assert "t = 0 s" in outcome.failures[1]
    assert outcome.failures[1] == str(outcome.data["failure"].values[0, 1])
    assert np.isnan(outcome.data["swing"].values[:, 1]).all()
    assert np.isfinite(outcome.data["swing"].values[:, 0]).all()
    assert study("c.k: [30, 50], c.joint.hinge.u: [0, 1.0e+300]").kept == 2


def test_start_values_hold_for_all_runs_and_have_units(study: Studies) -> None:
    data = study("c.k: [30 N/m, 0.05 kN/m]", "start: {c.joint.hinge.q: 30 deg}").data
    np.testing.assert_allclose(data["k"], [30.0, 50.0])
    other = study(f"c.k: [30, 50], c.joint.hinge.q: [{math.radians(30.0)!r}]", "start_up: 0").data
    np.testing.assert_allclose(data["swing"], other["swing"].values[:, 0], rtol=1e-12)


def test_points_that_are_alike_are_both_counted(study: Studies) -> None:
    outcome = study("c.k: [30, 30, 50]")
    assert study.progress[-1] == (3, 3)
    swing = outcome.data["swing"].values
    assert swing[0] == swing[1] != swing[2]


def test_values_are_checked_beside_those_of_their_run(study: Studies) -> None:
    """A lower limit of 0.05 m is wrong beside the file's upper one of 0 m, which no run has."""
    stop = "  stop: {type: joint_stop, joint: rail, stiffness: 1e4, lower: lo, upper: hi}\n"
    limits = "  lo: {value: -0.1, unit: m}\n  hi: {value: 0, unit: m}\n"
    changed_model(study.folder, "loads:\n", f"loads:\n{stop}")
    changed_model(study.folder, "parameters:\n", f"parameters:\n{limits}")
    assert study("c.lo: [-0.1, 0.05], c.hi: [0.2, 0.1]").failures == {}
    if not study.cart:  # a key of the file may change a parameter, and no other program comes of it
        keys = "both: {together: {parameters.hi.value: [0.2, 0.1], lo: [0.15, 0.05]}}"
        assert study(keys).failures == {}


def test_a_start_up_that_ends_within_the_ramp_of_a_sea_is_warned_of(study: Studies) -> None:
    ramp = "  ramp_time: {value: 0.1, unit: s}\n"
    changed_model(study.folder, "parameters:\n", f"parameters:\n{ramp}")
    changed_model(study.folder, "effort: -k*", "effort: -k/ramp_time*ramp_time*")
    outcome = study("c.ramp_time: [0.1, 0.3, 0.4]", "start_up: 0.2")
    (line,) = (line for line in outcome.warnings if "start_up" in line)
    assert line.startswith("start_up of 0.2 s ends within the ramp of the sea, of up to 0.4 s")
    assert outcome.warnings[line] == 2


def test_warnings_of_the_model_are_told_once_and_counted(study: Studies) -> None:
    odd = "  odd: {type: torsion_spring, bodies: [cart, bob], stiffness: -1}\n"
    changed_model(study.folder, "loads:\n", f"loads:\n{odd}")
    outcome = study()
    assert [count for line, count in outcome.warnings.items() if "stiffness" in line] == [4]
    assert len([line for line in study.warned if "stiffness" in line]) == 1
