"""Whole processes: model file to result file, and the memory that one needs."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

from benchmark.native_code import BUILD, ROOT
from benchmark.systems import GRAVITY, GROUND, System, pendulum

REPEATS = 3

_MEMORY = """
import json, sys
sys.path.insert(0, {tests!r})
from benchmark import measure
from benchmark.engines import ours
from benchmark.engines.pym4e_worker import memory, rest
import m4e_fmi.runtime.engine
before = rest()
engine = ours.integrator(measure.pendulum({n}), compiled=False)
ours.integrate(engine, measure.times(), method="dop853")
print(json.dumps(memory() - before))
"""


def whole_process(n: int) -> dict[str, float]:
    """CPU and wall time [s] of `m4e-fmi simulate` without a picture, 30 s, best of three."""
    BUILD.mkdir(parents=True, exist_ok=True)
    model = BUILD / f"pendulum_{n}.model.yaml"
    model.write_text(model_file(pendulum(n)), "utf-8")
    command = [str(Path(sys.executable).with_name("m4e-fmi")), "simulate", str(model)]
    command += ["--no-plot", "--stop-time", "30", "--output-file", str(BUILD / f"pendulum_{n}.nc")]
    best = {"wall": float("inf"), "cpu": float("inf")}
    for _ in range(REPEATS):
        began, spent = time.perf_counter(), _children()
        run = subprocess.run(command, capture_output=True, text=True, check=False, cwd=BUILD)
        if run.returncode:
            lines = run.stderr.strip().splitlines() or ["no message"]
            raise RuntimeError(f"m4e-fmi simulate ends with {run.returncode}: {lines[-1]}")
        best["wall"] = min(best["wall"], time.perf_counter() - began)
        best["cpu"] = min(best["cpu"], _children() - spent)
    return best


def memory(n: int) -> float:
    """Peak memory [bytes] that preparing and integrating 30 s adds to that of the imports."""
    code = _MEMORY.format(tests=str(ROOT / "tests"), n=n)
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    if run.returncode:
        raise RuntimeError(run.stderr.strip().splitlines()[-1])
    return json.loads(run.stdout)


def model_file(system: System) -> str:
    """A model file of a pendulum."""
    bodies, joints = [], []
    for k, link in enumerate(system.links):
        parent = "ground" if link.parent == GROUND else f"body{link.parent}"
        bodies.append(f"  body{k}: {{mass: {link.mass!r}, inertia: {link.inertia!r}}}")
        joints.append(
            f"  joint{k}: {{type: revolute, parent: {parent}, child: body{k}, "
            f"parent_to_joint: {list(link.parent_to_joint)}, "
            f"joint_to_child: {list(link.joint_to_child)}, "
            f"initial: {{q: {system.q[k]!r}, u: {system.u[k]!r}}}}}"
        )
    head = [f"name: {system.name}", f"gravity: {GRAVITY}"]
    return "\n".join([*head, "bodies:", *bodies, "joints:", *joints, ""])


def _children() -> float:
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def machine() -> dict[str, str]:
    """What this was measured on."""
    import platform

    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        lines = info.read_text("utf-8").splitlines()
        model = next(
            (k.split(":", 1)[1].strip() for k in lines if k.startswith("model name")), model
        )
    load = ", ".join(f"{value:.1f}" for value in os.getloadavg())
    return {
        "processor": f"{model}, {os.cpu_count()} cores",
        "system": platform.platform(),
        "python": platform.python_version(),
        "load": load,
    }
