"""Studies of models: ensembles and single simulations, the same numbers either way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.small_study import Here, written_study

import m4e_fmi
from m4e_fmi.errors import InputError
from m4e_fmi.runtime.engine import Engine
from m4e_fmi.study import StudyOutcome, run_study

STUDY = """\
name: carts
model: cart.model.yaml
simulation: {stop_time: 2}
sample: {method: latin_hypercube, count: 20, seed: 3, of: {k: [30, 50], joint.hinge.q: [0.1, 0.5]}}
wanted:
  swing: {variable: joint.hinge.q, statistic: maximum}
  push: {variable: load.spring.effort, statistic: rms}
"""


def made(path: Path, **given: object) -> StudyOutcome:
    return run_study(path, build_directory=path.parent / "build", **given)  # type: ignore[arg-type]


def test_members_of_an_ensemble_are_single_runs_of_the_engine(tmp_path: Path) -> None:
    outcome = made(written_study(tmp_path, STUDY))
    assert outcome.notes == ("20 runs are members of ensembles",)
    program = m4e_fmi.model_program(m4e_fmi.load_model(tmp_path / "cart.model.yaml"))
    for k in (0, 19):
        one = outcome.data.isel(sample=k)
        start = {"k": float(one["k"]), "joint.hinge.q": float(one["q"])}
        run = Engine(program.with_start(start)).simulate(np.arange(201) * 0.01)
        place = [v.name for v in program.states].index("joint.hinge.q")
        assert float(one["swing"]) == run.states[:, place].max()


def test_single_simulations_agree_with_the_ensemble(tmp_path: Path) -> None:
    """Errors of both are below the tolerance times the number of steps, some hundreds."""
    path = written_study(tmp_path, STUDY)
    together = made(path)
    path.write_text(STUDY.replace("stop_time: 2", "stop_time: 2, method: rodas"), "utf-8")
    single = made(path)
    assert "single simulations: the method rodas" in single.notes[0]
    np.testing.assert_allclose(single.data["swing"], together.data["swing"], rtol=1e-5)


def test_keys_of_the_model_are_varied(tmp_path: Path) -> None:
    """The mass is a number of the program: there is one program for each."""
    text = STUDY.replace("sample:", "vary: {bodies.bob.mass: [1, 2]}\nsample:")
    path = written_study(tmp_path, text.replace("count: 20", "count: 2"))
    found = made(path).data["swing"]
    model = (tmp_path / "cart.model.yaml").read_text("utf-8")
    (tmp_path / "cart.model.yaml").write_text(model.replace("bob: {mass: 1", "bob: {mass: 2"))
    path.write_text(STUDY.replace("count: 20", "count: 2"), "utf-8")
    np.testing.assert_array_equal(found.sel(mass=2), made(path).data["swing"])
    assert not np.array_equal(found.sel(mass=1), found.sel(mass=2))


def test_kept_members_are_not_made_again(tmp_path: Path) -> None:
    path = written_study(tmp_path, STUDY)
    made(path)
    assert made(path).kept == 20


def test_a_run_that_fails_does_not_stop_the_others(tmp_path: Path) -> None:
    text = STUDY.replace("of: {k: [30, 50], ", "of: {").replace(
        "sample:", "vary: {joint.rail.u: [0, 1.0e+300]}\nsample:"
    )
    outcome = made(written_study(tmp_path, text))
    assert len(outcome.failures) == 20
    assert np.isfinite(outcome.data["swing"].values[0]).all()
    assert "t = 0 s" in outcome.failures[20]


def test_a_composed_system_is_one_program(tmp_path: Path) -> None:
    text = (
        "name: carts\nsystem: system.yaml\nmethod: composed\nsimulation: {stop_time: 1}\n"
        "vary: {pto.damping: [2, 6]}\nwanted: {force: {variable: pto.force, statistic: rms}}\n"
    )
    path = written_study(tmp_path, text)
    whole = made(path).data["force"]
    path.write_text(text.replace("method: composed\n", ""), "utf-8")
    steps = made(path, executor=Here()).data["force"]
    np.testing.assert_allclose(whole, steps, rtol=0.02)  # coupled in steps of 0.02 s


def test_problems_come_together(tmp_path: Path) -> None:
    text = STUDY.replace("{k:", "{kk:").replace("joint.hinge.q, st", "joint.hing.q, st")
    with pytest.raises(InputError) as caught:
        made(written_study(tmp_path, text))
    assert [problem.line for problem in caught.value.problems] == [4, 6]


def test_values_that_no_simulation_has_are_told_with_their_lines(tmp_path: Path) -> None:
    """Before the first run: the others would be made before they are met."""
    text = "name: s\nmodel: cart.model.yaml\nsimulation: {stop_time: 0.5}\nvary:\n  k: [3]\n"
    wrong = (
        "  simulation.tolerance: [1.0e-6, -1]\n  simulation.method: [dop853, euler]\n"
        "  simulation.step_size: [0.1, soon]\n"
    )
    wanted = "wanted: {swing: {variable: joint.hinge.q, statistic: maximum}}\n"
    with pytest.raises(InputError) as caught:
        made(written_study(tmp_path, text + wrong + wanted))
    assert [problem.line for problem in caught.value.problems] == [6, 7, 8]


def test_a_start_up_that_leaves_no_row_is_told_with_its_line(tmp_path: Path) -> None:
    path = written_study(tmp_path, STUDY + "start_up: 2\n")
    with pytest.raises(InputError, match="no row counts: the start-up of 2 s") as caught:
        made(path)
    assert caught.value.problems[0].line == len(STUDY.splitlines()) + 1
