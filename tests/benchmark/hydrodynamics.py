"""Cost of hydrodynamics: a step of two bodies in 1,000 waves, potential flow, pressure on a hull.

Limits: 100 us of processor time a step of a run with native FMUs; potential flow of 1,500 panels
at 40 frequencies in 1.05 times what a script that calls Capytaine takes, on all cores. The script
solves the same problems, on the same mesh with the same planes of symmetry, and makes a dataset of
them. That nothing is lost where it is killed: tests/verify/test_killed_potential_flow.py.

    cd tests && ../.venv-bench/bin/python -m benchmark.hydrodynamics [step] [pressure] [flow]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

MODEL = """
name: two
dimensions: 3
gravity: 9.81
bodies:
  a: {mass: neutral, inertia: [8.0e+6, 3.0e+7, 3.5e+7], added_mass: true}
  b: {mass: neutral, inertia: [1.0e+6, 1.0e+6, 1.0e+6], added_mass: true}
joints:
  sea_a: {type: floating, child: a, initial: {z: -0.5}}
  sea_b: {type: floating, child: b, initial: {x: 30, z: -1}}
"""
SYSTEM = """
name: two
components:
  bodies: {model: two.model.yaml}
  hydro:
    kind: hydrodynamics
    dimensions: 3
    water: {density: 1025, depth: 50, gravity: 9.81}
    bodies:
      a:
        shape: {box: {length: 24, width: 12, draft: 2}}
        center_of_gravity: [0, 0, -0.5]
        panels: 200
      b:
        shape: {cylinder: {radius: 4, draft: 3, center_x: 30}}
        center_of_gravity: [30, 0, -1]
        panels: 200
    waves:
      spectrum: jonswap
      significant_height: 1.5
      peak_period: 8
      direction: 30
      seed: 1
      components: 1000
    frequencies: {maximum: 4, count: 16}
connections:
  - bodies.body.a <-> hydro.a
  - bodies.body.b <-> hydro.b
  - hydro.added_mass -> bodies.added_mass
simulation: {stop_time: 60, step_size: 0.1, algorithm: gauss_seidel}
"""
STEPS = (200, 2200)
STEP_LIMIT = 100e-6  # s
PANELS, FREQUENCIES, FLOW_LIMIT = 1500, 40, 1.05
HULL = """
bodies: {a: {shape: {box: {length: 24, width: 12, draft: 4}}, center_of_gravity: [0, 0, -0.5],
             panels: %d}}
dimensions: 3
water: {density: 1025, depth: %s, gravity: 9.81}
"""
ROUNDS = 5


def least(work: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Least processor seconds of a few runs."""
    times = []
    for _ in range(rounds):
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return min(times)


def verdict(value: float, limit: float) -> str:
    return "within" if value <= limit else "MISSED:"


def steps(folder: Path) -> None:
    """A step of a whole run, from runs of two lengths: what both have is the set-up."""
    from m4e_fmi.cosim import load_system, prepare, run

    (folder / "two.model.yaml").write_text(MODEL)
    (folder / "system.yaml").write_text(SYSTEM)
    system = load_system(folder / "system.yaml")
    size = system.simulation.step_size
    print("two bodies in space, 1,000 wave components, step of 0.1 s, certificate included:")
    for algorithm in ("jacobi", "gauss_seidel", "corrector"):
        spent = []
        for count in STEPS:
            changed = system.changed(algorithm=algorithm, stop_time=count * size)
            ready = prepare(changed, build_directory=folder / "build", tell=lambda _: None)
            spent.append(least(lambda ready=ready: run(ready)))
        each = (spent[1] - spent[0]) / (STEPS[1] - STEPS[0])
        text = f"  {algorithm:13} {1e6 * each:7.1f} us a step, {spent[0]:.2f} s for the first 200"
        judged = "" if algorithm == "corrector" else f", {verdict(each, STEP_LIMIT)} 100 us"
        print(text + judged)


def pressure(folder: Path) -> None:
    """An evaluation of the nonlinear pressure on a hull."""
    import json

    from ruamel.yaml import YAML

    from m4e_adapters.hydrodynamics.pressure.config import HullPressureConfig
    from m4e_adapters.hydrodynamics.pressure.hull_load import HullOutputs
    from m4e_fmus import hull_pressure

    for depth in ("deep", "50"):
        section = YAML(typ="safe").load(HULL % (1000, depth))
        section["bodies"]["a"]["shape"]["box"]["freeboard"] = 2.0
        section["waves"] = {
            "spectrum": "jonswap", "significant_height": 2, "peak_period": 8, "direction": 30,
            "components": 300,
        }  # fmt: skip
        config = HullPressureConfig.model_validate(section)
        build = hull_pressure.KIND.build
        source = build(config, name="h", folder=folder, progress=lambda _: None)
        hulls = HullOutputs(json.loads(source.data["hulls.json"]))
        given = {"a.z": -0.4, "a.x": 0.3, "a.theta": 0.03, "a.phi": 0.02}
        spent = least(lambda hulls=hulls, given=given: hulls.at(given, 30.0), 40)
        print(f"pressure on a hull of 1,000 panels, 300 components, {depth}: {1e3 * spent:.2f} ms")


def flow(folder: Path) -> None:
    """Potential flow beside a script; in finite depth also with Capytaine's own kernel."""
    for depth, count, others in (
        ("deep", FREQUENCIES, ["script"]),
        ("50", 6, ["script", "default"]),
    ):
        print(f"potential flow, {PANELS} panels, {count} frequencies, six motions, depth {depth}:")
        ours = _of_process("ours", depth, count, folder)
        for who in others:
            other = _of_process(who, depth, count, folder)
            wall, spent = (a / b for a, b in zip(ours, other, strict=True))
            judged = f", {verdict(spent, FLOW_LIMIT)} {FLOW_LIMIT}" if who == "script" else ""
            print(f"  ours over {who}: {wall:.3f}, of processor time {spent:.3f}{judged}")


def _of_process(who: str, depth: str, count: int, folder: Path) -> tuple[float, float]:
    """Wall time and processor time [s]."""
    environment = {**os.environ, "M4E_FMI_CACHE": str(folder / "cache")}
    environment.pop("OPENBLAS_NUM_THREADS", None)
    command = [sys.executable, "-m", "benchmark.potential_flow", who, depth]
    command += [str(PANELS), str(count)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    wall, spent = map(float, done.stdout.split()[-2:])
    print(f"  {who:7} {wall:7.1f} s, {spent / wall:.2f} cores", flush=True)
    return wall, spent


def main(wanted: list[str]) -> None:
    parts = {"step": steps, "pressure": pressure, "flow": flow}
    with tempfile.TemporaryDirectory() as name:
        for part in wanted or parts:
            parts[part](Path(name))


if __name__ == "__main__":
    main(sys.argv[1:])
