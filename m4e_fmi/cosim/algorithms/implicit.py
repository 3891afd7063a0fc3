"""Every step solves for the inputs: components and connections agree in the middle and at the end.

Unknown are the values of all connected inputs in the middle and at the end of the step. For given
values all components return to the start and make their step (see `pieces`); what their
outputs then differ by from the inputs they feed is the residual, which a quasi-Newton iteration
(`newton`) brings to zero. Its Jacobian begins with what outputs depend on at once: directional
derivatives, of FMUs that provide them. What inputs do during a step is learnt as the iteration
goes on. Of other FMUs, and where that does not converge, it comes from differences: one
more step of one component for each unknown.

So strong coupling costs no stability: a stiff spring between two components, or added mass that is
larger than the mass it acts on and comes back as a force. Algebraic loops at communication points
are solved too, with directional derivatives where FMUs have them. A step that does not converge
ends the run.

Second order: inputs follow straight lines. (A parabola, solved for its values, grows where an
oscillation makes half a turn in a step; straight lines are stable up to a whole turn, and always
where FMUs hold their inputs.) All FMUs must be able to go back.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.newton import DIFFERENCE, OF_NOMINAL, NotConvergedError, QuasiNewton
from m4e_fmi.cosim.network.restorable import Restorable
from m4e_fmi.cosim.network.schedule import Schedule
from m4e_fmi.cosim.stepping.input_interpolation import InputInterpolation
from m4e_fmi.cosim.stepping.pieces import ComponentStepper, InputTrajectories, StepValues
from m4e_fmi.cosim.stepping.step_control import Scale
from m4e_fmi.coupling_algorithms import AlgorithmDescriptor, LinkDelay
from m4e_fmi.errors import RunError

SEEN, WIDER, WIDENINGS = 1e-10, 1e3, 5
"""Share of its size by which an output must change for a usable difference; factor by which the
difference of the input grows until it does; largest number of attempts."""


class Implicit(Restorable):
    """Steps of all components, repeated until inputs and outputs agree."""

    order = 2
    restored = ("_newton", "_scale", "_felt")

    def __init__(self, network: Network) -> None:
        self._network = network
        count = len(network.inputs)
        self._inputs = np.zeros(3 * count)
        trajectories = InputTrajectories(self._inputs, np.arange(3 * count).reshape(3, count))
        self._step_values = values = StepValues(network, InputInterpolation.LINES, trajectories)
        self.held, self.followed = values.held, values.followed
        self.notes: tuple[str, ...] = ()
        self._scale = Scale(network, values.sources)
        nominals = [network.nominal(link.source) for link in network.links]
        self._least = OF_NOMINAL * np.array(nominals)
        self._felt = np.zeros(2 * count)
        self._newton = QuasiNewton()
        saved = [o for stepper in (*values.steppers, *values.sampled) for o in stepper.save]
        self._begin = Schedule([*saved, *values.begin])
        rest = [o for stepper in values.sampled for o in stepper.operations]
        self._end = Schedule([*rest, *values.mean])
        again = {s.name: (*s.restore, *s.operations) for s in values.steppers}
        self._again = {name: Schedule(operations) for name, operations in again.items()}
        self._all = Schedule([o for operations in again.values() for o in operations])

    def step(self, time: float, size: float) -> None:
        """Step all components from `time` by `size` [s]; RunError if the inputs are not found."""
        values, network = self._step_values, self._network
        network.size = size
        values.prepare(size)
        self._begin.run(time)
        self._inputs[: len(network.inputs)] = network.inputs
        one = np.maximum(self._scale.with_values(values.end), self._least)
        sizes = np.concatenate((one, one))
        self._solve(time, size, sizes, np.maximum(sizes, self._felt))
        network.roughness = max(network.roughness, self._newton.roughness)
        self._scale.keep(self._scale.with_values(values.end))
        self._end.run(time, size)

    def _solve(self, time: float, size: float, sizes: np.ndarray, scale: np.ndarray) -> None:
        """Find inputs of these `sizes` (2 n_inputs,) with which the step agrees."""
        network = self._network

        def residual(x: np.ndarray) -> np.ndarray:
            self._step(self._all, time, size, x)
            return self._found() - x

        def jacobian(x: np.ndarray, r: np.ndarray, again: bool) -> np.ndarray:
            matrix = self._jacobian(x, r, (time, size), scale, declared=not again)
            self._felt = np.abs(matrix + np.eye(len(x))) @ sizes
            np.maximum(scale, self._felt, out=scale)
            return matrix

        try:
            self._newton.solve(residual, jacobian, self._found(), scale)
        except NotConvergedError as failure:
            worst = network.links[failure.worst % len(network.links)]
            raise RunError(
                f"the inputs of the step from t = {time:.9g} s to {time + size:.9g} s could not be "
                f"found in {failure.iterations} iterations: {worst.target} still misses its source "
                f"{worst.source} by {failure.size:.3g} of its range",
                f"try a step_size below {size:g} s, or a smaller tolerance of the FMUs",
            ) from failure

    def undo(self) -> None:
        """Return all components to the start of the step."""
        self._step_values.undo()

    def _found(self) -> np.ndarray:
        """Values of the connected inputs' sources, in the middle and at the end; or known ones."""
        places = self._step_values.places
        return np.concatenate((self._network.values[places[1]], self._network.values[places[2]]))

    def _step(self, again: Schedule, time: float, size: float, x: np.ndarray) -> None:
        """Components' steps again, with inputs `x`."""
        self._inputs[len(self._inputs) - len(x) :] = x
        again.run(time, size)

    def _jacobian(
        self,
        x: np.ndarray,
        r: np.ndarray,
        step: tuple[float, float],
        scale: np.ndarray,
        *,
        declared: bool,
    ) -> np.ndarray:
        """Derivatives of the residual; an input changes the outputs of its own component only.

        With `declared`, those that FMUs provide. `step` is its start and size [s].
        """
        count = len(r) // 2
        matrix = -np.eye(2 * count)  # inputs of components that step more rarely change nothing
        for stepper in self._step_values.steppers:
            inputs = range(stepper.inputs.start, stepper.inputs.stop)
            description = self._network.instances[stepper.name].description
            if declared and description.directional_derivatives:
                matrix[:, [*inputs, *(k + count for k in inputs)]] = self._at_once(stepper)
                continue
            again = self._again[stepper.name]
            for column in (k + shift for k in inputs for shift in (0, count)):
                matrix[:, column] += self._difference(again, column, x, x + r, step, scale)
            self._step(again, *step, x)
        return matrix

    def _difference(
        self,
        again: Schedule,
        column: int,
        x: np.ndarray,
        found: np.ndarray,
        step: tuple[float, float],
        scale: np.ndarray,
    ) -> np.ndarray:
        """Derivatives of the outputs `found` for inputs `x` by one of them.

        A component makes its step `again` with the input moved by a share of its scale, or by more
        until an output changes.
        """
        slope = np.zeros_like(x)
        for wider in range(WIDENINGS):
            delta = DIFFERENCE * float(scale[column]) * WIDER**wider
            moved = x.copy()
            moved[column] += delta
            self._step(again, *step, moved)
            change = self._found() - found
            slope = change / delta
            if (np.abs(change) > SEEN * np.maximum(scale, np.abs(found))).any():
                break
        return slope

    def _at_once(self, stepper: ComponentStepper) -> np.ndarray:
        """Columns of the Jacobian for a component's inputs, in the middle and at the end."""
        network = self._network
        instance = network.instances[stepper.name]
        count, first = len(network.links), stepper.inputs.start
        inputs = network.links_to(stepper.name)
        block = np.zeros((count, len(inputs)))
        for row, link in enumerate(network.links):
            if link.source.component == stepper.name:
                known = instance.description.dependencies[link.source.variable]
                for column, into in enumerate(inputs):
                    if into.target.variable in known:
                        pair = (link.source.variable, into.target.variable)
                        slope = instance.directional_derivative(*pair)
                        block[row, column] = instance.scales.factor(into.ends) * slope
        block[first : first + len(inputs)] -= np.eye(len(inputs))
        return np.block([[block, np.zeros_like(block)], [np.zeros_like(block), block]])


ALGORITHM = AlgorithmDescriptor(
    name="implicit",
    summary="steps are repeated until inputs and outputs agree in the middle and at the end",
    order=Implicit.order,
    link_delay=LinkDelay.SOLVED,
    needs_rollback=True,
    stability=2,
    make=Implicit,
)
