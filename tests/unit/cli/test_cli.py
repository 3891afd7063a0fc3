"""The command line: what each command prints and writes; mistakes are in tests/corpus."""

from __future__ import annotations

import html
import json
import math
import re
import subprocess
import sys

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from support.command_line import EXAMPLES, FLEXIBLE, PENDULUM

from m4e_fmi.cli import main
from m4e_fmi.fmu import read_description
from m4e_fmi.results import results_file as results

SWING = """name: swing
parameters: {L: {value: 220, unit: cm}}
bodies: {child: {mass: 30, inertia: 1}}
joints: {branch: {type: revolute, child: child, joint_to_child: [0, -L]}}
"""


SWINGS = """name: swings
components:
  a: {model: swing.model.yaml}
  b: {model: swing.model.yaml, start: {L: 2.5}}
simulation: {stop_time: 0.1, step_size: 0.05}
"""


def test_a_bare_start_value_is_si_and_one_with_a_unit_is_converted(here, capsys):
    """In a simulation, a linearization and a run, whatever the unit in the model file."""
    (here / "swing.model.yaml").write_text(SWING)
    (here / "system.yaml").write_text(SWINGS)
    heights = []
    for length, angle in (("2.5", "60 deg"), ("250 cm", str(math.pi / 3))):
        chosen = ["--start-value", "L", length, "--start-value", "joint.branch.q", angle]
        short = ["--stop-time", "0.1", "--no-plot", "--output-file", "s.nc"]
        assert main(["simulate", "swing.model.yaml", *short, *chosen]) == 0
        heights.append(results.load("s.nc")["swing.body.child.z"].values)
        assert main(["linearize", "swing.model.yaml", "--at", "start", *chosen]) == 0
        assert re.search(r"branch\.q +1\.04719755 rad", capsys.readouterr().out)
    # -2.5 m · cos 60°, but for the rounding of the angle
    assert heights[0][0] == pytest.approx(-1.25, rel=1e-15)
    assert np.array_equal(heights[0], heights[1])
    wanted = ["--variables", "a.L", "b.L", "--start-value", "a.L", "250 cm"]
    assert main(["run", "system.yaml", "--output-file", "r.nc", *wanted]) == 0
    run = results.load("r.nc")
    assert {*run["a.L"].values, *run["b.L"].values} == {2.5}


@pytest.mark.usefixtures("here")
def test_simulate_tells_events_and_where_the_energy_went(capsys):
    arguments = ["simulate", str(PENDULUM), "--stop-time", "5", "--no-plot", "--verbose"]
    assert main([*arguments, "--event", "body.lower.x", "--stop-at", "joint.elbow.u"]) == 0
    text = capsys.readouterr().out
    assert re.search(r"load\.elbow_damper\.work +-\d", text)
    ((percent, joule),) = re.findall(r"energy balance closes to (\S+) % of .*, (\S+) J", text)
    assert 0 < float(percent) < 1e-4  # tolerance 1e-8 in some hundred steps
    assert float(joule) > 100
    (end,) = re.findall(r"joint\.elbow\.u +(\S+) s, the end", text)
    assert f"double_pendulum: {float(end):g} s in" in text


def test_build_validate_info(here, capsys):
    fmu = "build/double_pendulum.fmu"
    assert main(["build", str(PENDULUM)]) == 0
    assert (here / fmu).stat().st_size < 3e6
    assert main(["validate", fmu]) == 0
    assert "no errors, no warnings" in capsys.readouterr().out
    assert main(["info", fmu]) == 0
    assert "joint.elbow.q" in capsys.readouterr().out
    assert main(["build", str(PENDULUM), "--native", "--fmi", "3"]) == 0
    assert validate_fmu(fmu) == []


def test_build_with_options(here):
    options = ["--native", "--no-documentation", "--inputs", "point.*", "--outputs", "body.upper.*"]
    options += ["--inputs", "*.elbow.effort", "--outputs", "energy.*"]
    options += ["--stop-time", "3"]
    assert main(["build", str(PENDULUM), *options]) == 0
    description = read_description(here / "build" / "double_pendulum.fmu")
    inputs = {v.name for v in description.of_causality("input")}
    outputs = {v.name for v in description.of_causality("output")}
    assert inputs == {"point.tip.force_x", "point.tip.force_z", "joint.elbow.effort"}
    assert {name.split(".")[0] for name in outputs} == {"body", "energy"}


def test_draw_and_animate(here, capsys):
    assert main(["draw", str(PENDULUM)]) == 0
    assert main(["draw", str(PENDULUM), "--output-file", "drawing.svg"]) == 0
    short = ["simulate", str(PENDULUM), "--stop-time", "0.5", "--no-plot", "--animate"]
    assert main(short) == 0
    assert main([*short, "moves.html"]) == 0
    files = ("build/double_pendulum_model.png", "drawing.svg", "build/double_pendulum.html",
             "moves.html")  # fmt: skip
    told = capsys.readouterr().out
    for name in files:
        assert (here / name).stat().st_size > 5000
        assert re.search(rf"wrote .*{re.escape(name)}", told)


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize(("value", "alike"), [("200 cm", True), ("3", False)])
def test_an_animation_has_the_lengths_that_are_given(here, dimensions, value, alike):
    (here / "arm.model.yaml").write_text(
        f"name: arm\ndimensions: {dimensions}\nparameters: {{L: {{value: 1, unit: m}}}}\n"
        f"bodies: {{arm: {{mass: 1, inertia: {[1, [1, 1, 1]][dimensions - 2]}}}}}\n"
        f"joints: {{hinge: {{type: revolute, child: arm, joint_to_child: "
        f"{['[L, 0]', '[L, 0, 0], axis: [0, 1, 0]'][dimensions - 2]}}}}}\n"
    )
    command = ["simulate", "arm.model.yaml", "--stop-time", "0.1", "--no-plot", "--animate"]
    plain, other = (here / f"{name}.html" for name in ("plain", "other"))
    for given, file in (("2", plain), (value, other)):
        assert main([*command, str(file), "--start-value", "L", given]) == 0
    assert (plain.read_bytes() == other.read_bytes()) == alike


def test_the_report_of_a_run_that_failed(here, capsys):
    code = """
class Fuse:
    parameters = {"last": (0.2, "s")}
    outputs = {"y": "1"}

    def step(self, t, h, v):
        if t > v.last:
            raise ValueError("blown <b>")
        return {"y": t}
"""
    (here / "fuse.py").write_text(code)
    system = """name: fuses
components: {fuse: {kind: python, file: fuse.py}}
connections: []
simulation: {stop_time: 1, step_size: 0.1, algorithm: jacobi}
"""
    (here / "system.yaml").write_text(system)
    assert main(["run", "system.yaml", "--output-file", "s.nc"]) == 1
    assert "blown" in capsys.readouterr().err
    assert main(["report", "s.nc", "--output-file", "r.html"]) == 0
    page = (here / "r.html").read_text("utf-8")
    assert "The run ended early: failed: fuse" in page
    assert html.escape("blown <b>") in page


def test_reports(here, capsys):
    """Of a simulation beside its results, of a run where it is asked for."""
    short = ["simulate", str(PENDULUM), "--stop-time", "0.5", "--no-plot"]
    assert main([*short, "--report"]) == 0
    assert "build/double_pendulum.report.html" in capsys.readouterr().out
    page = (here / "build/double_pendulum.report.html").read_text("utf-8")
    command = f"m4e-fmi simulate {PENDULUM} --stop-time 0.5 --no-plot --report"
    for text in (command, "energy balance closes to", PENDULUM.read_text("utf-8")[:60]):
        assert html.escape(text) in page
    (here / "swing.model.yaml").write_text(SWING)
    (here / "system.yaml").write_text(SWINGS)
    assert main(["run", "system.yaml", "--report", "r.html", "--output-file", "s.nc"]) == 0
    page = (here / "r.html").read_text("utf-8")
    for text in (SWING, SWINGS, "m4e-fmi run system.yaml --report r.html --output-file s.nc"):
        assert html.escape(text) in page
    assert main(["report", "s.nc"]) == 0
    assert "wrote s.report.html" in capsys.readouterr().out
    again = (here / "s.report.html").read_text("utf-8")
    assert html.escape(SWINGS) in again
    assert '"flows":' in again


def test_a_system_runs_from_its_file_and_from_its_package(here, capsys):
    system, short = str(FLEXIBLE / "system.yaml"), ["--stop-time", "0.1", "--step-size", "0.005"]
    assert main(["run", system, *short, "--start-value", "body.M", "9e4", "--verbose"]) == 0
    text = capsys.readouterr().out
    for said in ("20 steps of 0.005 s", "largest coupling error", "body.end <-> line.end"):
        assert said in text
    for name in ("flexible_pendulum.nc", "flexible_pendulum.png"):
        assert (here / "build" / name).stat().st_size > 1000
    assert main(["run", system, *short, "--no-plot"]) == 0
    assert not (here / "build" / "flexible_pendulum.png").exists()  # that of the run before
    assert main(["build", system, "--ssp"]) == 0
    assert "wrote build/flexible_pendulum.ssp" in capsys.readouterr().out
    for command in (["run", "build/flexible_pendulum.ssp", *short],
                    ["info", "build/flexible_pendulum.ssp"]):  # fmt: skip
        assert main([*command, *(["--verbose"] * (command[0] == "run"))]) == 0
        assert "body.end <-> line.end" in capsys.readouterr().out


def test_info_builds_nothing_that_takes_long(here, capsys):
    """The potential flow of an example, say: the system is shown as it is written."""
    system = EXAMPLES / "sphere_decay" / "system.yaml"
    assert main(["info", str(system)]) == 0
    told = capsys.readouterr().out
    assert "water  hydrodynamics  (not built yet)" in told
    assert "body.sphere <-> water.sphere" in told
    assert not (here / "build").exists()


def test_a_run_with_a_parameter_set_and_chosen_variables(here, capsys):
    (here / "heavy.yaml").write_text("values: {body.M: 8e4}\n")
    system = str(FLEXIBLE / "system.yaml")
    short = ["--stop-time", "0.1", "--step-size", "0.005", "--output-file", "out.csv"]
    chosen = ["--variables", "body.M", "--variables", "body.point.*", "--parameters", "heavy.yaml"]
    assert main(["run", system, *short, *chosen]) == 0
    assert "wrote out.nc, out.csv, out.png\n" in capsys.readouterr().out
    header, first, *_ = (here / "out.csv").read_text().splitlines()
    assert header.startswith("time [s],body.M [kg],body.point.")
    assert first.startswith("0.0,80000.0,")
    assert (here / "out.nc").exists()
    assert main(["info", system, "--output-file", "graph.svg", "--algorithm", "jacobi"]) == 0
    assert "one step late" in capsys.readouterr().out
    assert (here / "graph.svg").stat().st_size > 5000


def test_help_imports_nothing_heavy():
    heavy = ("sympy", "numpy", "scipy", "matplotlib", "netCDF4", "fmpy", "capytaine", "pydantic")
    code = (
        "import sys\nfrom m4e_fmi.cli import main\n"
        "try: main(['--help'])\nexcept SystemExit: pass\n"
        f"print([m for m in {heavy!r} if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"
    assert len(done.stdout.splitlines()) < 35


def test_linearize_the_paper_s_double_pendulum(capsys) -> None:
    assert main(["linearize", str(PENDULUM)]) == 0
    text = capsys.readouterr().out
    assert "double_pendulum: equilibrium, t = 0 s" in text
    # the end of a long simulation, which settles there
    assert re.search(r"joint\.shoulder\.q +-2\.2045", text)
    assert re.search(r" 1 +– +– +1\.00000 +-3\.53655\n", text)  # it does not oscillate
    assert "no motion grows" in text


def test_linearize_as_json(capsys) -> None:
    arguments = ["--inputs", "joint.elbow.effort", "--outputs", "point.tip.x", "--json"]
    arguments += ["--inputs", "joint.shoulder.effort"]
    assert main(["linearize", str(PENDULUM), *arguments]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert [v["name"] for v in printed["outputs"]] == ["point.tip.x"]
    shapes = {name: np.shape(printed[name]) for name in "ABCD"}
    assert shapes == {"A": (4, 4), "B": (4, 2), "C": (1, 4), "D": (1, 2)}
    assert np.shape(printed["mechanical"]["F"]) == (2, 2)
    assert len(printed["modes"]) == 3
    assert printed["stable"] is True


def test_an_fmu_alone(here, capsys):
    """It is run as a system of one component, whose name may be left out."""
    assert main(["build", str(PENDULUM), "--native", "--stop-time", "3", "--step-size", "0.1"]) == 0
    fmu = "build/double_pendulum.fmu"
    capsys.readouterr()
    assert main(["simulate", fmu, "--verbose"]) == 0
    out = capsys.readouterr().out
    assert "simulated 3 s" in out
    assert "30 steps of 0.1 s" in out
    assert (here / "build" / "double_pendulum.png").is_file()
    short = ["--stop-time", "1", "--step-size", "0.05", "--output-interval", "0.1", "--no-plot"]
    chosen = ["--start-value", "L", "200 cm", "--variables", "L", "point.*"]
    assert main(["run", fmu, *short, *chosen, "--output-file", "r.nc"]) == 0
    found = results.load_results("r.nc")
    assert found.time == pytest.approx(np.linspace(0.0, 1.0, 11))
    assert set(found["double_pendulum.L"].values) == {2.0}
    shown = ["simulate", str(PENDULUM), "--start-value", "L", "2", "--stop-time", "1", "--no-plot"]
    assert main([*shown, "--output-interval", "0.1", "--output-file", "s.nc"]) == 0
    alone = results.load_results("s.nc")["double_pendulum.point.tip.z"]
    assert found["double_pendulum.point.tip.z"].values == pytest.approx(alone.values, abs=1e-6)


def test_equations_of_an_fmu_are_its_own(here, capsys):
    (here / "x.fmu").write_bytes(b"")
    with pytest.raises(SystemExit, match="2"):
        main(["simulate", "x.fmu", "--method", "rk4"])
    assert "unrecognized arguments: --method rk4" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [(["help"], "co-simulate a system"), (["help", "decay"], "usage: m4e-fmi decay")],
)
def test_help(words, said, capsys):
    with pytest.raises(SystemExit, match="0"):
        main(words)
    assert said in capsys.readouterr().out


@pytest.mark.parametrize(
    ("word", "said"), [("swim", "known: run, simulate, "), ("simulat", "did you mean 'simulate'")]
)
def test_unknown_commands(word, said, capsys):
    with pytest.raises(SystemExit, match="2"):
        main([word])
    assert said in capsys.readouterr().err


def test_design_by_one_command(here, capsys):
    """A mass of 3 kg on a spring: k = m omega², c = 2 zeta m omega."""
    (here / "spring.model.yaml").write_text(
        "name: spring\nparameters: {k: {value: 1, unit: N/m}, c: {value: 0, unit: N.s/m}}\n"
        "bodies: {block: {mass: 3, inertia: 1}}\n"
        "joints: {rail: {type: prismatic, child: block, direction: [1, 0]}}\n"
        "loads: {s: {type: joint_effort, joint: rail, "
        "effort: -k*joint.rail.q - c*joint.rail.u}}\n"
    )
    command = ["equilibrium", "spring.model.yaml", "--such-that", "mode 1 frequency", "2 Hz"]
    damped = ["--such-that", "mode 1 damping", "5 %", "--vary", "k", "c"]
    assert main([*command, *damped, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    omega = 4.0 * math.pi
    assert found["k"] == pytest.approx(3.0 * omega**2, rel=1e-9)
    assert found["c"] == pytest.approx(0.3 * omega, rel=1e-9)
    assert main([*command, "--vary", "c"]) == 1
    assert "mode 1 frequency [Hz] = 0.0918" in capsys.readouterr().err
    assert main([*command, *damped, "--quiet"]) == 0
    assert not capsys.readouterr().out
    assert main(["linearize", "spring.model.yaml", "--quiet"]) == 0
    assert not capsys.readouterr().out
