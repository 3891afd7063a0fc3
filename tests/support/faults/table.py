"""Faults of FMUs: kinds and calls of faulty.c, and what a run in which one strikes must come to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Outcome = Literal["fails", "ends", "either"]

SET_UP = ("instantiate", "setup", "enter", "exit", "initialise")
RUNNING = ("get", "set", "step")
STATES = ("save", "restore", "forget")
BYTES = ("serialize",)
CLOSING = ("terminate", "free")
EVERYWHERE = (*SET_UP, *RUNNING, *STATES, *BYTES, *CLOSING)

NAMES: dict[str, dict[int, str]] = {
    "instantiate": {1: "fmiInstantiateSlave", 2: "fmi2Instantiate", 3: "fmi3Instantiate"},
    "initialise": {1: "fmiInitializeSlave"},
    "setup": {2: "fmi2SetupExperiment"},
    "enter": {2: "fmi2EnterInitializationMode", 3: "fmi3EnterInitializationMode"},
    "exit": {2: "fmi2ExitInitializationMode", 3: "fmi3ExitInitializationMode"},
    "get": {1: "fmiGetReal", 2: "fmi2GetReal", 3: "fmi3GetFloat64"},
    "set": {1: "fmiSetReal", 2: "fmi2SetReal", 3: "fmi3SetFloat64"},
    "step": {1: "fmiDoStep", 2: "fmi2DoStep", 3: "fmi3DoStep"},
    "save": {2: "fmi2GetFMUstate", 3: "fmi3GetFMUState"},
    "restore": {2: "fmi2SetFMUstate", 3: "fmi3SetFMUState"},
    "forget": {2: "fmi2FreeFMUstate", 3: "fmi3FreeFMUState"},
    "serialize": {2: "fmi2SerializeFMUstate", 3: "fmi3SerializeFMUState"},
    "terminate": {1: "fmiTerminateSlave", 2: "fmi2Terminate", 3: "fmi3Terminate"},
    "free": {1: "fmiFreeSlaveInstance", 2: "fmi2FreeInstance", 3: "fmi3FreeInstance"},
}
"""Functions of each version of FMI, by the name of the call in a plan."""


@dataclass(frozen=True)
class Kind:
    """A kind of fault, the calls in which it strikes, the run's outcome, and words of its error."""

    name: str
    outcome: Outcome
    says: str = ""
    calls: tuple[str, ...] = EVERYWHERE


LIMIT = "within 1 s"
KINDS = (
    # the process ends
    Kind("segv", "fails", "SIGSEGV"),
    Kind("abort", "fails", "SIGABRT"),
    Kind("throw", "fails", "SIGABRT"),
    Kind("stack", "fails", "SIGSEGV"),
    Kind("heap", "fails", "SIGABRT|SIGSEGV"),
    Kind("fpe", "fails", "SIGFPE"),
    Kind("exit", "fails", "exit code 0"),
    Kind("_exit", "fails", "exit code 0"),
    Kind("sigkill", "fails", "SIGKILL"),
    Kind("hog", "fails", f"SIGABRT|{LIMIT}", (*SET_UP, *RUNNING)),
    Kind("late", "either", "SIGABRT"),  # a thread, in another call, or after the last
    # no answer comes
    Kind("spin", "fails", LIMIT),
    Kind("sleep", "fails", LIMIT),
    Kind("sigstop", "fails", LIMIT),
    Kind("pthread_exit", "fails", f"{LIMIT}|exit code 0"),
    # an answer of FMI that says it
    Kind("error", "fails", "ran dry", (*SET_UP[1:], *RUNNING, "save", "restore")),
    Kind("fatal", "fails", "ran dry", (*SET_UP[1:], *RUNNING, "save", "restore")),
    Kind("discard", "fails", "Discard", ("step",)),
    Kind("negative", "fails", "no status of FMI", (*SET_UP[1:], *RUNNING, "save", "restore")),
    Kind("nan", "fails", "nan", ("get",)),
    Kind("inf", "fails", "inf", ("get",)),
    # surroundings that are the FMU's own
    Kind("thread", "ends"),
    Kind("fork", "ends"),
    Kind("twin", "ends"),
    Kind("rounding", "ends"),
    Kind("locale", "ends"),
    Kind("chdir", "ends"),
    Kind("stdout", "ends"),
    Kind("signals", "ends"),
    Kind("log", "ends", calls=(*SET_UP[1:], *RUNNING)),
    Kind("close", "either"),
    Kind("slow", "ends", calls=("step",)),
)


@dataclass(frozen=True)
class Fault:
    """A fault in a `component`, from the `count`-th `call` on after a step to `since` [s]."""

    component: str
    call: str
    kind: Kind
    since: float = 0.0
    count: int = 1

    @property
    def plan(self) -> str:
        """The line of the file `plan` that arms it."""
        return f"{self.component} {self.call} {self.kind.name} {self.since!r} {self.count}\n"
