"""Studies of models: ensembles and single simulations, the same numbers either way."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.small_study import Here, written_study

import m4e_fmi
from m4e_fmi.errors import InputError
from m4e_fmi.runtime.engine import Engine
from m4e_fmi.study import StudyOutcome, run_study
from m4e_fmi.study.programs import plan

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


def test_a_compiled_ensemble_has_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written_study(tmp_path, STUDY)
    first = made(path, jobs=1)
    compiled: list[bool] = []
    compile_ = Engine.compile

    def noted(engine: Engine) -> bool:
        compiled.append(compile_(engine))
        return compiled[-1]

    monkeypatch.setattr(Engine, "compile", noted)
    monkeypatch.setattr(plan, "COMPILING_PAYS", 0.0)
    second = made(path, jobs=1, fresh=True)
    assert set(compiled) == {True}  # after the first part, which shows how long they take
    for name in ("swing", "push"):
        np.testing.assert_array_equal(first.data[name], second.data[name])


def test_what_is_compiled_stays_compiled() -> None:
    """Also for the last runs, which alone would not pay for it."""
    compiling = plan._Compiling(100)
    assert not compiling.pays
    compiling.note(8, 8.0)
    assert compiling.pays
    compiling.note(92, 0.1)
    assert compiling.pays
    few = plan._Compiling(100)
    few.note(90, 1.0)
    assert not few.pays


def test_no_run_begins_after_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also while someone holds the error, as a notebook does, and with it all frames."""
    make, go_on, begun = plan.ProgramPlan._chunk, threading.Event(), list[int]()

    def noted(*given: Any, **keys: Any) -> plan.Batch:
        begun.append(1)
        if len(begun) > 1:
            go_on.wait(20.0)
        return make(*given, **keys)

    def interrupted(done: int, _: int) -> None:
        if done:
            raise KeyboardInterrupt

    monkeypatch.setattr(plan.ProgramPlan, "_chunk", noted)
    before = threading.enumerate()
    with pytest.raises(KeyboardInterrupt) as held:
        made(written_study(tmp_path, STUDY), jobs=1, progress=interrupted)
    go_on.set()
    for thread in {*threading.enumerate()} - {*before}:
        thread.join(20.0)
    assert len(begun) <= 2  # of 3 chunks
    assert held


def test_warnings_of_the_model_are_told_once_and_counted(tmp_path: Path) -> None:
    path = written_study(tmp_path, STUDY.replace("count: 20", "count: 2"))
    model = tmp_path / "cart.model.yaml"
    odd = "  odd: {type: torsion_spring, bodies: [cart, bob], stiffness: -1}\n"
    text = model.read_text("utf-8").replace("loads:\n", f"loads:\n{odd}")
    model.write_text(text, "utf-8")
    told: list[str] = []
    outcome = made(path, tell=told.append)
    assert [count for line, count in outcome.warnings.items() if "stiffness" in line] == [2]
    assert len([line for line in told if "stiffness" in line]) == 1


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


def test_few_runs_are_shared_among_the_threads(tmp_path: Path) -> None:
    """Each makes several calls of the library: what is done is told, and kept."""
    done: list[int] = []
    made(written_study(tmp_path, STUDY), jobs=2, progress=lambda now, _: done.append(now))
    assert sorted(np.diff(done)) == [4, 8, 8]


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


def test_units_of_columns_and_texts_are_converted(tmp_path: Path) -> None:
    """Names of columns say deg and N/cm; the result has numbers in the variable's units."""
    text = STUDY[: STUDY.index("sample:")] + STUDY[STUDY.index("wanted:") :]
    text += (
        "vary: {joint.hinge.u: [0.1, 30 deg/s]}\n"
        'table: {file: t.csv, columns: {joint.hinge.q: "q [deg]", k: "k [N/cm]"}}\n'
    )
    path = written_study(tmp_path, text)
    (tmp_path / "t.csv").write_text("q [deg],k [N/cm]\n10,0.3\n20,0.5\n", "utf-8")
    data = made(path).data
    np.testing.assert_allclose(data["q"], np.radians([10.0, 20.0]), rtol=1e-15)
    np.testing.assert_allclose(data["k"], [30.0, 50.0], rtol=1e-15)
    np.testing.assert_allclose(data["u"], [0.1, np.pi / 6.0], rtol=1e-15)
    (tmp_path / "t.csv").write_text("q,k\n0.17453292519943295,30\n0.3490658503988659,50\n")
    path.write_text(text.replace(" [deg]", "").replace(" [N/cm]", "").replace("30 deg/s", "0.5236"))
    np.testing.assert_allclose(made(path).data["swing"][0], data["swing"][0], rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "column", "message"),
    [
        ("k", "k [kg]", "k: the column 'k \\[kg\\]': it is in N/m"),
        ("bodies.bob.mass", "m [g]", "'m \\[g\\]' names a unit, but the key bodies.bob.mass"),
    ],
)
def test_units_of_columns_that_do_not_fit(
    tmp_path: Path, name: str, column: str, message: str
) -> None:
    text = STUDY[: STUDY.index("sample:")] + STUDY[STUDY.index("wanted:") :]
    path = written_study(
        tmp_path, f'{text}table: {{file: t.csv, columns: {{{name}: "{column}"}}}}\n'
    )
    (tmp_path / "t.csv").write_text(f"{column},n\n10,0.3\n", "utf-8")
    with pytest.raises(InputError, match=message) as caught:
        made(path)
    (problem,) = caught.value.problems
    assert problem.line == len(text.splitlines()) + 1


def test_an_angle_is_no_unit_of_a_key(tmp_path: Path) -> None:
    """Of components: angles of some sections are in deg, of others in rad."""
    text = (
        "name: carts\nsystem: system.yaml\nmethod: composed\nsimulation: {stop_time: 1}\n"
        'table: {file: t.csv, columns: {pto.damping: "d [rad]"}}\n'
        "wanted: {force: {variable: pto.force, statistic: rms}}\n"
    )
    path = written_study(tmp_path, text)
    (tmp_path / "t.csv").write_text("d [rad],n\n10,0.3\n", "utf-8")
    with pytest.raises(InputError, match=r"'d \[rad\]' names a unit, but the key damping"):
        made(path)


def test_wrong_start_values_are_told_together_by_line(tmp_path: Path) -> None:
    text = (
        STUDY + "vary: {joint.rail.u: [.nan], joint.hinge.u: [fast]}\nstart: {joint.rail.q: 3 kg}\n"
    )
    path = written_study(tmp_path, text)
    lines = len(STUDY.splitlines())
    with pytest.raises(InputError) as caught:
        made(path)
    found = [(p.line - lines, p.message.partition(":")[0]) for p in caught.value.problems]
    outside = "joint.rail.u = nan is outside its range from -inf to inf"
    assert sorted(found) == [(1, "joint.hinge.u"), (1, outside), (2, "joint.rail.q")]


def test_a_start_up_of_the_whole_run_is_refused_by_its_line(tmp_path: Path) -> None:
    path = written_study(tmp_path, f"{STUDY}start_up: 2\n")
    with pytest.raises(InputError, match="start_up 2 s leaves nothing of runs of 2 s") as caught:
        made(path)
    assert caught.value.problems[0].line == len(STUDY.splitlines()) + 1
    text = STUDY.replace("model: cart.model.yaml", "system: system.yaml").replace(
        "k: [30, 50], joint", "cart.k: [30, 50], cart.joint"
    )
    text = text.replace("variable: ", "variable: cart.")
    path.write_text(f"{text}start_up: 3\n", "utf-8")
    with pytest.raises(InputError, match="start_up 3 s leaves nothing of runs of 2 s"):
        made(path)


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


def test_angles_of_an_attitude_are_start_values_of_all_runs(tmp_path: Path) -> None:
    """As for single simulations: no variable is called so, the states are a quaternion."""
    (tmp_path / "top.model.yaml").write_text(
        "name: top\ndimensions: 3\ngravity: 0\n"
        "parameters: {m: {value: 2, unit: kg}}\n"
        "bodies: {hull: {mass: m, inertia: [1, 2, 3]}}\n"
        "joints: {free: {type: floating, child: hull}}\n",
        encoding="utf-8",
    )
    path = tmp_path / "study.yaml"
    path.write_text(
        "name: tops\nmodel: top.model.yaml\nsimulation: {stop_time: 0.1}\n"
        "start: {body.hull.phi: 30 deg}\nvary: {m: [2, 4]}\n"
        "wanted: {phi: {variable: body.hull.phi, statistic: mean}}\n",
        encoding="utf-8",
    )
    np.testing.assert_allclose(made(path).data["phi"], np.radians(30.0), rtol=1e-12)


STOPS = """\
name: stops
model: stop.model.yaml
simulation: {stop_time: 0.1}
vary: {lo: [-0.1, 0.05, 0.15], hi: [0.2, 0.1]}
wanted: {most: {variable: load.stop.effort, statistic: maximum}}
"""
STOP = """\
name: stop
gravity: 0
parameters: {lo: {value: -0.1, unit: m}, hi: {value: 0, unit: m}}
bodies: {block: {mass: 1, inertia: 1}}
joints: {rail: {type: prismatic, child: block, direction: [1, 0]}}
loads: {stop: {type: joint_stop, joint: rail, stiffness: 1e4, lower: lo, upper: hi}}
"""


STOP_SYSTEM = """\
name: stops
components:
  rig: {model: stop.model.yaml}
  push: {kind: table, times: [0, 1], signals: {f: {unit: N, values: [0, 1]}}}
connections: [push.f -> rig.body.block.force_x]
simulation: {stop_time: 0.1, step_size: 0.01}
"""


@pytest.mark.parametrize("source", ["model", "composed", "system"])
def test_values_are_checked_together(source: str, tmp_path: Path) -> None:
    """0.15 is wrong beside one value only, and 0.05 beside the file's 0, which no run has."""
    (tmp_path / "stop.model.yaml").write_text(STOP, "utf-8")
    (tmp_path / "system.yaml").write_text(STOP_SYSTEM, "utf-8")
    path, text = tmp_path / "study.yaml", STOPS
    if source != "model":
        method = "\nmethod: composed" if source == "composed" else ""
        text = text.replace("model: stop.model.yaml", f"system: system.yaml{method}")
        text = (
            text.replace("lo:", "rig.lo:").replace("hi:", "rig.hi:").replace(": load", ": rig.load")
        )
    path.write_text(text, "utf-8")
    with pytest.raises(InputError) as caught:
        made(path, executor=Here())
    (problem,) = caught.value.problems
    assert (problem.line, problem.message) == (
        6,
        "the lower limit 0.15 is not below the upper one, 0.1 (with lo = 0.15, hi = 0.1): "
        "in 1 of 6 runs",
    )
    path.write_text(text.replace(", 0.15]", "]"), "utf-8")
    assert made(path, executor=Here()).failures == {}


def test_values_are_checked_beside_those_of_keys(tmp_path: Path) -> None:
    """A key of the file may change a parameter, and no other program comes of it."""
    (tmp_path / "stop.model.yaml").write_text(STOP, "utf-8")
    text = STOPS.replace("hi: [0.2, 0.1]", "parameters.hi.value: [0.1, 0.2]")
    with pytest.raises(InputError) as caught:
        made(written_study(tmp_path, text))
    (problem,) = caught.value.problems
    assert problem.message.endswith("(with lo = 0.15, hi = 0.1): in 1 of 6 runs")
    for pairs in ("[0.1, 0.2], lo: [-0.1, 0.15]", "[0.2, 0.1], lo: [0.15, 0.05]"):
        both = f"{{both: {{together: {{parameters.hi.value: {pairs}}}}}}}"
        given = text.replace("{lo: [-0.1, 0.05, 0.15], parameters.hi.value: [0.1, 0.2]}", both)
        assert made(written_study(tmp_path, given)).failures == {}


def test_a_system_is_composed_once_where_no_key_varies(tmp_path: Path) -> None:
    """What is told of it is told once."""
    (tmp_path / "stop.model.yaml").write_text(STOP, "utf-8")
    (tmp_path / "push.py").write_text(PUSH, "utf-8")
    push = "{kind: table, times: [0, 1], signals: {f: {unit: N, values: [0, 1]}}}"
    system = STOP_SYSTEM.replace(push, "{kind: python, file: push.py}")
    (tmp_path / "system.yaml").write_text(system, "utf-8")
    path, told = tmp_path / "study.yaml", list[str]()
    text = STOPS.replace("model: stop.model.yaml", "system: system.yaml\nmethod: composed")
    text = text.replace("lo: [-0.1, 0.05, 0.15], hi: [0.2, 0.1]", "rig.lo: [-0.1, -0.2]")
    path.write_text(text.replace(": load", ": rig.load"), "utf-8")
    made(path, tell=told.append)
    assert told == ["push: push.py is recorded as a program"]


PUSH = """\
class Push:
    outputs = {"f": "N"}

    def calculate(self, t, v):
        return {"f": t}
"""


def test_points_that_are_alike_are_made_once_and_both_counted(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    text = (
        "name: alike\nmodel: cart.model.yaml\nvary: {k: [30, 30, 50]}\n"
        "simulation: {stop_time: 0.1}\n"
        "wanted: {swing: {variable: joint.hinge.q, statistic: maximum}}\n"
    )
    path = written_study(tmp_path, text)
    outcome = made(path, progress=lambda *n: told.append(n))
    assert told[-1] == (3, 3)
    assert outcome.data["swing"].values[0] == outcome.data["swing"].values[1]


def test_a_start_up_that_ends_within_the_ramp_of_a_sea_is_warned_of(tmp_path: Path) -> None:
    """As where systems are co-simulated."""
    study = f"{STUDY}start_up: 0.2\n".replace("[30, 50]", "[30, 50], ramp_time: [0.1, 0.3]")
    path = written_study(tmp_path, study)
    model = tmp_path / "cart.model.yaml"
    text = model.read_text("utf-8").replace("effort: -k*", "effort: -k/ramp_time*ramp_time*")
    parameter = "parameters:\n  ramp_time: {value: 0.1, unit: s}\n"
    model.write_text(text.replace("parameters:\n", parameter, 1), "utf-8")
    outcome = made(path)
    (line,) = (line for line in outcome.warnings if "start_up" in line)
    longest = float(outcome.data["ramp_time"].max())
    assert line.startswith(
        f"start_up of 0.2 s ends within the ramp of the sea, of up to {longest:g} s"
    )
    assert outcome.warnings[line] == int((outcome.data["ramp_time"] > 0.2).sum()) == 10
