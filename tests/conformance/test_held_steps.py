"""Communication steps between which nothing is set: they cut no step of the integrator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from support.fmu_instances import FILES, Instance
from support.runtime_programs import waves

from m4e_fmi.program import Recorder, Variable, rate_entries
from m4e_fmi.program.functions import minimum, sqrt
from m4e_fmi.runtime.engine import Control, Engine, Integrator

METHODS = pytest.mark.parametrize("method", ["dop853", "rk45", "rodas"])
KINDS = pytest.mark.parametrize("kind", FILES)
H = 0.0625  # s; sums of it are exact
STATES = ["x", "v", "y"]
Open = Callable[..., Instance]


@pytest.fixture
def held(load: Open) -> Open:
    """`held(kind, program, method)`: an instance of `waves`, or another program, initialised."""

    def made(kind: str, method: str = "dop853", program: object = None) -> Instance:
        return load(kind, program or waves(), built={"method": method}).initialise()

    return made


def rows(instance: Instance, first: int, last: int) -> list[list[float]]:
    """States and outputs after each of the steps from `first` to `last`."""
    found = []
    for k in range(first, last):
        instance.step(k * H, H)
        found.append(instance.get([*STATES, "elevation", "force"]))
    return found


def uncut(method: str, steps: int) -> tuple[np.ndarray, int]:
    """States after each step, and attempts: the first step cut at its end, no other one."""
    program = waves()
    engine = Engine(program, jacobian=rate_entries(program) if method == "rodas" else ())
    integrator = Integrator(engine, Control(method))
    integrator.start(0.0, [0.2, 0.2, 0.2])
    first = integrator.advance([H], bound=H)
    integrator.start(H, first[0], step=integrator.report.step)
    rest = [integrator.advance([k * H], bound=(k + 100) * H)[0] for k in range(2, steps + 1)]
    return np.array([*first, *rest]), integrator.report.accepted + integrator.report.rejected


@KINDS
@METHODS
def test_steps_are_those_of_one_integration(held: Open, method: str, kind: str) -> None:
    expected, attempts = uncut(method, 60)
    assert attempts < 60 or method != "dop853"  # it pays
    found = np.array(rows(held(kind, method), 0, 60))
    np.testing.assert_array_equal(found[:, :3], expected)


@KINDS
@pytest.mark.parametrize(("name", "value"), [("push", 3.0), ("height", 0.2)])
def test_what_is_set_counts_from_then_on(held: Open, kind: str, name: str, value: float) -> None:
    """The same value changes no bit; another one is that of an integration from there."""
    one, other = held(kind), held(kind)
    for k in range(1, 31):
        other.set({"push": 0.1, "height": 0.05})
        assert rows(one, k - 1, k) == rows(other, k - 1, k)
    engine = Engine(waves())
    engine.set_inputs([value if name == "push" else 0.1])
    engine.set_parameters([value if name == "height" else 0.05])
    control = Control(rtol=1e-12, atol=1e-12)
    exact = engine.simulate([30 * H, 40 * H], states=one.get(STATES), control=control)
    one.set({name: value})
    found = rows(one, 30, 40)[-1][:3]
    np.testing.assert_allclose(found, exact.states[-1], atol=1e-7)
    assert np.abs(np.array(rows(other, 30, 40)[-1][:3]) - found).max() > 1e-3


@KINDS
@METHODS
def test_saved_states_bring_back_every_bit(held: Open, method: str, kind: str) -> None:
    """Also within a step of the integrator, also as bytes, in the same or in a new instance."""
    undisturbed, instance = rows(held(kind, method), 0, 40), held(kind, method)
    for k in range(20):
        assert rows(instance, k, k + 1) == [undisturbed[k]]
        saved = instance.save()
        if k % 5 == 0:
            instance.set({"push": 4.0})
            rows(instance, k + 1, k + 4)
        instance.restore(saved)
    content = instance.pack(instance.save())
    assert rows(instance, 20, 40) == undisturbed[20:]
    other = held(kind, method)
    rows(other, 0, 7)
    other.restore(other.unpack(content))
    assert rows(other, 20, 40) == undisturbed[20:]
    other.fmu.reset()
    other.initialise()
    assert rows(other, 0, 40) == undisturbed


@KINDS
@pytest.mark.parametrize("method", ["dop853", "rk45"])  # rodas takes the slope of one side
def test_corners_in_time_are_not_stepped_across(held: Open, method: str, kind: str) -> None:
    """x' = min(t, 1/2): a polynomial on either side, exact where a step ends at t = 1/2."""
    r = Recorder("ramp", "")
    r.state(Variable("x", "1", ""))
    r.rate("x", minimum(r.time, 0.5))
    instance = held(kind, method, r.program())
    for k in range(16):
        instance.step(k * H, H)
        t = (k + 1) * H
        exact = 0.5 * t * t if t < 0.5 else 0.5 * t - 0.125
        assert instance["x"] == pytest.approx(exact, abs=1e-14)


@KINDS
@METHODS
def test_the_end_of_what_is_defined(held: Open, method: str, kind: str) -> None:
    """x' = sqrt(1 - t) has no value after t = 1; steps up to there succeed."""
    r = Recorder("end", "")
    r.state(Variable("x", "1", ""))
    r.rate("x", sqrt(1.0 - r.time))
    instance = held(kind, method, r.program())
    for k in range(16):
        instance.step(k * H, H)
        exact = 2.0 / 3.0 * (1.0 - (1.0 - (k + 1) * H) ** 1.5)
        assert instance["x"] == pytest.approx(exact, abs=1e-6)
