"""Native FMUs of FMI 2.0, as far as these differ: phases, derivatives of inputs, discards."""

from __future__ import annotations

import ctypes
import math
import threading
from collections.abc import Callable
from ctypes import byref, c_double, c_int, c_size_t, c_uint
from typing import Any

import pytest
from support.fmu_instances import DISCARD, ERROR, Instance, answers

Load = Callable[..., Instance]


def test_phases_of_model_exchange(load: Load) -> None:
    instance = load("native 2, exchange")
    model, two = instance.fmu, [0.5, 2.0]
    instance.enter()
    model.exitInitializationMode()
    answers(ERROR, lambda: instance.put_states(two))
    answers(ERROR, lambda: model.completedIntegratorStep())
    instance.set({"stiffness": 31.0})
    instance.settle()
    model.enterContinuousTimeMode()
    answers(ERROR, lambda: instance.set({"stiffness": 30.0}))
    answers(ERROR, lambda: model.enterContinuousTimeMode())
    answers(ERROR, lambda: model.setContinuousStates((c_double * 2)(*two), 1))
    answers(DISCARD, lambda: instance.put_states([math.nan, 0.0]))
    assert instance.call("DoStep", c_double(0.0), c_double(0.1), 1) == ERROR
    instance.put_states(two)
    assert instance.rates().tolist() == [2.0, (1.0 - 31.0 * 0.5 - 0.4 * 2.0) / 2.0]
    instance.set({"x": 0.6})  # not in the standard; CasADi does it
    assert instance.rates()[1] == (1.0 - 31.0 * 0.6 - 0.4 * 2.0) / 2.0
    assert model.completedIntegratorStep() == (False, False)
    model.enterEventMode()
    model.terminate()


def test_a_discarded_step_says_how_far_it_came(load: Load) -> None:
    """x = 1/(1 − t): the solver comes close to t = 1."""
    instance = load("native 2", "fragile").initialise()
    answers(DISCARD, lambda: instance.step(0.0, 1.5))
    reached, ended = c_double(), c_int()
    instance.call("GetRealStatus", 2, byref(reached))
    instance.call("GetBooleanStatus", 3, byref(ended))
    assert reached.value == pytest.approx(1.0, abs=1e-6)
    assert instance["x"] > 1e5
    assert not ended.value
    answers(ERROR, lambda: instance.step(reached.value, 0.1))


@pytest.mark.parametrize(
    ("built", "error"),
    [
        ({}, 1e-9),
        ({"method": "rodas"}, 1e-6),  # 1e-8 in each of some hundred steps
        ({"method": "rk4", "step_size": 2.0}, 1e-14),  # one step, exact to its order of four
    ],
)
def test_inputs_follow_their_derivatives(load: Load, built: dict[str, Any], error: float) -> None:
    """Without spring and damper x'' = force/2: a force of 1 + 2 t + 3 t² gives a polynomial."""
    free = {"stiffness": 0.0, "damping": 0.0, "x": 0.0}
    instance = load("native 2", built=built).initialise(free)
    r, fmu = instance.references["force"], instance.fmu
    fmu.setRealInputDerivatives([r, r], [1, 2], [2.0, 6.0])
    saved = instance.pack(instance.save())
    for _ in range(2):
        instance.step(0.0, 2.0)
        assert instance["x"] == pytest.approx((2.0 + 8.0 / 3.0 + 4.0) / 2.0, rel=error)
        assert instance["force"] == 17.0
        # (2 + 3·4)/2: the force still rises at the end of its curve
        assert instance.output_rates(["a"]) == [7.0]
        v = instance["v"]
        instance.step(2.0, 1.0)  # held: derivatives are those of one step
        assert instance["v"] == pytest.approx(v + 8.5, rel=error)
        instance.restore(instance.unpack(saved))  # which has them, too
    for order, value in ((3, 1.0), (1, math.nan)):
        answers(ERROR, lambda o=order, v=value: fmu.setRealInputDerivatives([r], [o], [v]))


def test_instances_in_threads(load: Load) -> None:
    instance = load("native 2", "pendulum")
    library, guid = instance.fmu.dll, instance.description.guid.encode()
    resources = (instance.folder / "resources").as_uri().encode()
    reference = (c_uint * 1)(instance.references["body.lower.theta"])
    callbacks, found = byref(instance._messages.callbacks), []

    def run(k: int) -> None:
        make = library.fmi2Instantiate
        c = ctypes.c_void_p(make(b"%d" % k, 1, guid, resources, callbacks, 0, 0))
        library.fmi2EnterInitializationMode(c)
        library.fmi2ExitInitializationMode(c)
        for i in range(50):
            library.fmi2DoStep(c, c_double(0.01 * i), c_double(0.01), 1)
        value = (c_double * 1)()
        library.fmi2GetReal(c, reference, c_size_t(1), value)
        library.fmi2FreeInstance(c)
        found.append(value[0])

    threads = [threading.Thread(target=run, args=(k,)) for k in range(50)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    instance.initialise()
    for i in range(50):
        instance.step(0.01 * i, 0.01)
    assert found == [instance["body.lower.theta"]] * 50
