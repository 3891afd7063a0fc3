"""Ctrl-C while a call of an FMU does not end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals come otherwise there")


def executed(code: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)


HANGS = """
import ctypes, os, signal, threading, time
from m4e_fmi.cosim.network import interruption

interruption.PATIENCE = interruption.TICK = 0.05

def press():
    for _ in range(2):
        time.sleep(0.3)
        os.kill(os.getpid(), signal.SIGINT)

with interruption.stepping(where=lambda: " (after t = 3 s)"):
    threading.Thread(target=press, daemon=True).start()
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])  # others take it: sleep goes on
    ctypes.CDLL(None).sleep(20)
"""


def test_ctrl_c_tells_what_it_waits_for_and_the_second_one_ends() -> None:
    done = executed(HANGS)
    assert done.returncode == 128 + signal.SIGINT
    first, second = done.stderr.splitlines()
    assert first == (
        "waiting for an FMU to end its step (after t = 3 s); press Ctrl-C again to end at once"
    )
    assert second.startswith("ended by SIGINT")


def test_in_a_shell_it_tells_what_a_second_one_does() -> None:
    code = "import sys\nsys.ps1 = ''\n" + HANGS.replace("sleep(20)", "sleep(1)")
    done = executed(code)
    assert "interrupt again to end it if it is Python code" in done.stderr.splitlines()[0]


MANY = """
import os, resource, time
from m4e_fmi.cosim.network import interruption

resource.setrlimit(resource.RLIMIT_NOFILE, (1200, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
held = [os.open(os.devnull, os.O_RDONLY) for _ in range(1100)]
halts = []
with interruption.stepping(lambda: halts.append(1)):
    time.sleep(0.5)
print(len(halts))
"""


def test_steps_are_interrupted_in_a_process_that_has_many_files_open() -> None:
    done = executed(MANY)
    assert (done.returncode, done.stderr) == (0, "")
    assert int(done.stdout) >= 2
