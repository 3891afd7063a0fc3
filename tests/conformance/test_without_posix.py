"""Without modules that only POSIX has, as on Windows, a process imports and runs all."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

PENDULUM = """name: pendulum
bodies: {a: {mass: 2, inertia: 0.1}}
joints: {j: {type: revolute, child: a, joint_to_child: [0, -1], initial: {q: 0.3}}}
"""
SYSTEM = """name: one
components:
  body: {model: pendulum.model.yaml}
  total: {kind: sum, inputs: [a, b], unit: rad}
connections: [body.joint.j.q -> total.a]
simulation: {stop_time: 0.02, step_size: 0.01, algorithm: jacobi}
"""
WITHOUT = """
import builtins, importlib, os, pkgutil, signal, sys
gone = {"fcntl", "resource", "pwd", "grp", "termios", "posix", "pty", "syslog"}
plain = builtins.__import__
def narrow(name, globals=None, *more, **named):
    importer = (globals or {}).get("__name__", "")
    if name.partition(".")[0] in gone and importer.startswith(("m4e_", "__main__")):
        raise ModuleNotFoundError(f"{importer} imports {name}")
    return plain(name, globals, *more, **named)
builtins.__import__ = narrow
for name in ("fork", "forkpty", "killpg", "setsid", "sysconf",
             "sched_getaffinity", "pread", "fchmod", "mkfifo"):
    if hasattr(os, name):
        delattr(os, name)
for name in ("SIGHUP", "SIGALRM", "SIGKILL", "SIGUSR1", "SIGUSR2", "SIGPIPE", "SIGCHLD", "SIGQUIT",
             "SIGSTOP", "setitimer", "alarm", "pthread_sigmask"):
    if hasattr(signal, name):
        delattr(signal, name)
"""
IMPORTS = """
count = 0
for package in ("m4e_fmi", "m4e_adapters", "m4e_fmus"):
    root = importlib.import_module(package)
    for module in pkgutil.walk_packages(root.__path__, f"{package}."):
        if ".embedded." not in module.name and not module.name.endswith(".slave"):  # in FMUs only
            importlib.import_module(module.name)
            count += 1
print(count, "modules")
"""
RUNS = """
from types import ModuleType, SimpleNamespace
from m4e_fmi.files import locks
from m4e_fmi.cli import main
locks.sys = SimpleNamespace(platform="win32")  # so that it locks as there, by this:
sys.modules["msvcrt"] = windows = ModuleType("msvcrt")
windows.LK_NBLCK, windows.locking = 2, lambda descriptor, mode, count: None
codes = [
    main(["simulate", "pendulum.model.yaml", "--stop-time", "0.02", "--no-plot"]),
    main(["run", "system.yaml"]),
    main(["validate", "build/one/body.fmu", "--only", "description"]),
]
assert codes == [0, 0, 0], codes
"""


def test_all_is_imported_and_runs(tmp_path: Path) -> None:
    (tmp_path / "pendulum.model.yaml").write_text(PENDULUM)
    (tmp_path / "system.yaml").write_text(SYSTEM)
    command = [sys.executable, "-c", WITHOUT + IMPORTS + RUNS]
    # pretended locks are given to all: in the folder of others it would tidy up after living ones
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(done.stdout.split()[0]) > 250  # modules
