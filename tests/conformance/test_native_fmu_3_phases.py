"""Every function of FMI 3.0 in every state of the state machine answers as the standard says."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import POINTER, byref, c_bool, c_double, c_int32, c_size_t, c_uint, c_uint8, c_uint64
from typing import Any

import pytest
from fmpy import fmi3
from support.fmu_instances import Instance

OK, ERROR = 0, 3
PHASES = {
    "CoSimulation": ("instantiated", "initializing", "stepping", "within a step", "terminated"),
    "ModelExchange": ("instantiated", "initializing", "event", "continuous", "terminated"),
}
ALL = {phase for phases in PHASES.values() for phase in phases}
EXCHANGE = {"event", "continuous"}
NOT_WITHIN = ALL - {"within a step"}
EVALUATED = ALL - {"instantiated"}

ALLOWED: dict[str, set[str]] = {
    "GetVersion": ALL,
    "SetDebugLogging": ALL,
    "EnterInitializationMode": {"instantiated"},
    "ExitInitializationMode": {"initializing"},
    "EnterEventMode": {"continuous"},
    "Terminate": {"event", "continuous", "stepping"},
    "Reset": NOT_WITHIN,
    "EnterConfigurationMode": set(),  # there are no structural parameters
    "ExitConfigurationMode": set(),
    "GetFloat64": ALL,
    "GetString": ALL,
    "SetFloat64": ALL - {"terminated"},
    "GetFMUState": NOT_WITHIN,
    "SetFMUState": NOT_WITHIN,
    "FreeFMUState": ALL,
    "SerializedFMUStateSize": ALL,
    "SerializeFMUState": ALL,
    "DeserializeFMUState": ALL,
    "GetDirectionalDerivative": EVALUATED,
    "GetAdjointDerivative": EVALUATED,
    "EvaluateDiscreteStates": {"event"},
    "UpdateDiscreteStates": {"event"},
    "EnterContinuousTimeMode": {"event"},
    "CompletedIntegratorStep": {"continuous"},
    "SetTime": EXCHANGE,
    "SetContinuousStates": {"continuous"},
    "EnterStepMode": set(),  # nor an event mode of co-simulation
    "DoStep": {"stepping"},
    "ActivateModelPartition": set(),
}
"""Function → states in which it may be called."""
ONLY_STEPPING = {"GetOutputDerivatives": {"stepping", "within a step", "terminated"}}
"""The same, of co-simulation only."""
ONLY_EXCHANGE = {
    "GetContinuousStates": EVALUATED,
    "GetContinuousStateDerivatives": EVALUATED,
    "GetEventIndicators": EVALUATED,
    "GetNominalsOfContinuousStates": EVALUATED,
    "GetNumberOfEventIndicators": NOT_WITHIN,
    "GetNumberOfContinuousStates": NOT_WITHIN,
}
"""The same, of model exchange only."""
TYPES = ("Float32", *(f"{u}Int{n}" for u in ("", "U") for n in (8, 16, 32, 64)), "Boolean")
NONE_THERE = {
    *(f"{verb}{kind}" for verb in ("Get", "Set") for kind in (*TYPES, "Binary", "Clock")),
    *("GetIntervalDecimal", "GetIntervalFraction", "GetShiftDecimal", "GetShiftFraction"),
    *("SetIntervalDecimal", "SetIntervalFraction", "SetShiftDecimal", "SetShiftFraction"),
    *("SetString", "GetNumberOfVariableDependencies", "GetVariableDependencies"),
}
"""Functions of variables that the FMU has none of: an error in every state."""


@pytest.fixture(params=PHASES)
def instance(request: Any, load: Callable[..., Instance]) -> Instance:
    if request.param == "ModelExchange":
        return load("native 3, exchange", "plane")
    return load("native 3", "plane", intermediateUpdate=lambda *_: _CALLBACK[-1]())


_CALLBACK: list[Callable[[], None]] = [lambda: None]


def calls(instance: Instance, state: Any) -> dict[str, tuple[Any, ...]]:
    """Function → sound arguments, for the variable of the two forces where there is a choice."""
    r = instance.references
    force = (c_uint * 2)(r["body.ball.force_x"], r["body.ball.force_z"])
    a = (c_uint * 2)(r["body.ball.ax"], r["body.ball.az"])
    text = (c_uint * 1)(r["last_error"])
    one, two, four, none = c_size_t(1), c_size_t(2), c_size_t(4), c_size_t(0)
    pair, quad = (c_double * 2)(0.0, 0.0), (c_double * 4)(0.3, 1.3, 0.0, 0.0)
    flags = [byref(c_bool()) for _ in range(5)]
    number, size = byref(c_double()), c_size_t()
    instance.call("SerializedFMUStateSize", state, byref(size))
    content = (c_uint8 * size.value)()
    instance.call("SerializeFMUState", state, content, size)
    made = ctypes.c_void_p()
    derivative = a, two, force, two, pair, two, pair, two
    return {
        "SetDebugLogging": (True, none, None),
        "EnterInitializationMode": (False, 0.0, 0.0, False, 0.0),
        "GetFloat64": (force, two, pair, two),
        "SetFloat64": (force, two, pair, two),
        "GetString": (text, one, (ctypes.c_char_p * 1)(), one),
        "GetNumberOfVariableDependencies": (a[0], byref(c_size_t())),
        "GetVariableDependencies": (a[0], None, None, None, None, none),
        "GetFMUState": (byref(made),),
        "SetFMUState": (state,),
        "FreeFMUState": (byref(made),),
        "SerializedFMUStateSize": (state, byref(c_size_t())),
        "SerializeFMUState": (state, content, size),
        "DeserializeFMUState": (content, size, byref(made)),
        "GetDirectionalDerivative": derivative,
        "GetAdjointDerivative": derivative,
        "UpdateDiscreteStates": (*flags, number),
        "CompletedIntegratorStep": (True, flags[0], flags[1]),
        "SetTime": (0.0,),
        "SetContinuousStates": (quad, four),
        "GetContinuousStates": (quad, four),
        "GetContinuousStateDerivatives": (quad, four),
        "GetNominalsOfContinuousStates": (quad, four),
        "GetEventIndicators": (pair, none),
        "GetNumberOfEventIndicators": (byref(c_size_t()),),
        "GetNumberOfContinuousStates": (byref(c_size_t()),),
        "DoStep": (0.0, 0.1, True, *flags[:3], number),
        "GetOutputDerivatives": (a, two, (c_int32 * 2)(1, 1), pair, two),
        "ActivateModelPartition": (c_uint(0), 0.0),
        **_of_other_types(force, one),
    }


def _of_other_types(r: Any, one: Any) -> dict[str, tuple[Any, ...]]:
    room = {kind: (getattr(fmi3, f"fmi3{kind}") * 1)() for kind in TYPES}
    decimals, counters = (c_double * 1)(), (c_uint64 * 1)()
    sizes, binary = (c_size_t * 1)(), (POINTER(c_uint8) * 1)()
    qualifiers = (ctypes.c_int * 1)()
    return {
        **{f"{v}{kind}": (r, one, room[kind], one) for v in ("Get", "Set") for kind in TYPES},
        **{f"{v}Binary": (r, one, sizes, binary, one) for v in ("Get", "Set")},
        **{f"{v}Clock": (r, one, (fmi3.fmi3Clock * 1)()) for v in ("Get", "Set")},
        "SetString": (r, one, (ctypes.c_char_p * 1)(b"x"), one),
        "GetIntervalDecimal": (r, one, decimals, qualifiers),
        "GetIntervalFraction": (r, one, counters, counters, qualifiers),
        "GetShiftDecimal": (r, one, decimals),
        "GetShiftFraction": (r, one, counters, counters),
        "SetIntervalDecimal": (r, one, decimals),
        "SetIntervalFraction": (r, one, counters, counters),
        "SetShiftDecimal": (r, one, decimals),
        "SetShiftFraction": (r, one, counters, counters),
    }


def expected(name: str, phase: str, kind: str) -> int:
    table = ONLY_EXCHANGE if kind == "ModelExchange" else ONLY_STEPPING
    return OK if phase in {**ALLOWED, **table}.get(name, set()) else ERROR


def test_every_function_in_every_state(instance: Instance) -> None:
    fmu, kind = instance.fmu, ("ModelExchange" if instance.exchange else "CoSimulation")
    names = sorted({*ALLOWED, *ONLY_STEPPING, *ONLY_EXCHANGE, *NONE_THERE} - {"GetVersion"})
    checked: list[str] = []
    wrong: list[tuple[str, str, int]] = []  # no assertion leaves a callback

    def check(phase: str) -> None:
        state = fmu.getFMUState() if phase != "within a step" else before
        for name in names:
            instance.messages.clear()
            status = instance.call(name, *calls(instance, state).get(name, ()))
            told = [text for how, text in instance.messages if how == ERROR]
            silent = status == ERROR and not (told and f"fmi3{name}" in told[-1])
            if status != expected(name, phase, kind) or silent:
                wrong.append((name, phase, status))
            if phase != "within a step":
                fmu.setFMUState(state)
        checked.append(phase)

    def within() -> None:
        if "within a step" not in checked:
            check("within a step")

    check("instantiated")
    fmu.enterInitializationMode()
    check("initializing")
    fmu.exitInitializationMode()
    if kind == "CoSimulation":
        check("stepping")
        before = fmu.getFMUState()
        _CALLBACK.append(within)
        instance.step(0.0, 0.1)
        _CALLBACK.pop()
    else:
        check("event")
        fmu.enterContinuousTimeMode()
        check("continuous")
    fmu.terminate()
    check("terminated")
    assert wrong == []
    assert set(checked) == set(PHASES[kind])
