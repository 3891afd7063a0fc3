"""The same circuit as code that cannot be recorded: a solver of SciPy, and a check of its own."""

from scipy.integrate import solve_ivp

from .circuit import Circuit


class AccumulatorFullError(Exception):
    """There is no room for gas any more."""


class Accumulator:
    """The oil in the accumulator [m3] and the energy that the motor has delivered [J].

    AccumulatorFullError if there is more oil than gas_volume, now or later.
    """

    def __init__(self, circuit: Circuit, oil: float, energy: float = 0.0) -> None:
        _check(circuit, oil)
        self.circuit = circuit
        self.oil = oil
        self.energy = energy

    def advance(self, time: float, duration: float, speed: float, *, tolerance: float) -> None:
        """Go on for `duration` [s] with the rod at `speed` [m/s]; `tolerance` is relative."""

        def rates(_, state):
            oil = state[0]
            _check(self.circuit, oil)
            return [self.circuit.oil_rate(oil, speed), self.circuit.delivered(oil)]

        span, start = (time, time + duration), [self.oil, self.energy]
        solved = solve_ivp(rates, span, start, rtol=tolerance, atol=[1e-9, 1e-3])
        if not solved.success:
            raise RuntimeError(solved.message)
        self.oil, self.energy = solved.y[:, -1].tolist()


def _check(circuit: Circuit, oil: float) -> None:
    if oil >= circuit.gas_volume:
        raise AccumulatorFullError(f"{oil:.3g} m3 of oil: take a larger gas_volume")
