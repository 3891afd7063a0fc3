"""Bodies in still water as linear systems: of the program's own equations, and without them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_fmi.program import Program
from m4e_fmi.program.derivatives import rate_entries
from m4e_fmi.runtime.engine import Engine


@dataclass(frozen=True)
class Memory:
    """ẋ = A x + B v, force = C x + D v, of all motions' velocities v; A∞ as `added_mass`."""

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: np.ndarray
    added_mass: np.ndarray

    @classmethod
    def of(cls, program: Program, data: Coefficients) -> Memory:
        """Those of a program of hydrodynamics in the plane."""
        forces = [
            f"{body}.radiation_{motion.force}"
            for body in data.bodies
            for motion in data.body_motions
        ]
        velocities = [
            f"{body}.{motion.velocity}" for body in data.bodies for motion in data.body_motions
        ]
        engine = Engine(program, outputs=forces, jacobian=rate_entries(program))
        count = len(program.states)
        names = [v.name for v in program.inputs]
        start = np.array([v.start for v in program.inputs])
        columns, direct = [], []
        for name in velocities:
            given = start.copy()
            given[names.index(name)] = 1.0
            engine.set_inputs(given)
            columns.append(engine.rates(0.0, np.zeros(count)))
            direct.append(engine.outputs(0.0, np.zeros(count)))
        engine.set_inputs(start)
        unit = np.eye(count)
        outputs = np.array([engine.outputs(0.0, x) for x in unit])
        calculated = dict(
            zip([v.name for v in program.calculated], engine.calculated(), strict=True)
        )
        size = range(1, len(velocities) + 1)
        added = np.array([[calculated[f"added_mass[{i},{j}]"] for j in size] for i in size])
        jacobian = engine.jacobian(0.0, np.zeros(count))[:, :count]
        return cls(jacobian, np.array(columns).T, outputs.T, np.array(direct).T, added)

    def transfer(self, omega: np.ndarray) -> np.ndarray:
        """K(jω) (n, m, m) at `omega` (n,) [rad/s]."""
        unit = np.eye(len(self.a))
        states = (np.linalg.solve(1j * w * unit - self.a, self.b) for w in omega)
        return np.array([-self.c @ x - self.d for x in states])

    def released(
        self,
        *,
        mass: np.ndarray,
        stiffness: np.ndarray,
        damping: np.ndarray,
        start: np.ndarray,
        time: np.ndarray,
    ) -> np.ndarray:
        """Displacements (n, m) at equal steps of `time` (n,) [s], from rest at `start` (m,)."""
        m, k = len(mass), len(self.a)
        inverse = np.linalg.inv(mass + self.added_mass)
        whole = np.zeros((2 * m + k,) * 2)
        whole[:m, m : 2 * m] = np.eye(m)
        whole[m : 2 * m] = inverse @ np.hstack([-stiffness, self.d - damping, self.c])
        whole[2 * m :, m : 2 * m] = self.b
        whole[2 * m :, 2 * m :] = self.a
        step = expm(whole * (time[1] - time[0]))
        state = np.concatenate([start, np.zeros(m + k)])
        course = [state]
        for _ in time[1:]:
            course.append(step @ course[-1])
        return np.array(course)[:, :m]


def released_exactly(
    data: Coefficients,
    motion: int,
    *,
    mass: float,
    stiffness: float,
    start: float,
    time: np.ndarray,
) -> np.ndarray:
    """Displacement (n,) [m] of one motion at `time` (n,) [s] from the A(ω) and B(ω) of the table.

    Its velocity is (2/π) ∫ Re V cos ωt dω, where V is that of the impedance jω (m + A) + B + C/jω.
    """
    from scipy.interpolate import CubicSpline

    knots, end = data.omega, float(data.omega[-1])
    at = slice(None), motion, motion
    omega = np.concatenate([np.linspace(knots[0] * 1e-6, end, 20001), np.geomspace(end, 400, 4001)])
    steps = np.gradient(omega)
    steps[20000:20002] = 0.5 * (omega[20000] - omega[19999]), 0.5 * (omega[20002] - omega[20001])
    steps[[0, -1]] *= 0.5
    beyond = np.maximum(omega / end, 1.0)
    inside = np.clip(omega, knots[0], end)
    damping = CubicSpline(np.append(0.0, knots), np.append(0.0, data.radiation_damping[at]))
    added = CubicSpline(knots, data.added_mass[at] - data.added_mass_inf[motion, motion])
    inertia = mass + data.added_mass_inf[motion, motion] + added(inside) / beyond**2
    resistance = damping(np.minimum(omega, end)) / beyond**5
    impedance = 1j * omega * inertia + resistance + stiffness / (1j * omega)
    velocity = np.real(-stiffness * start / (1j * omega) / impedance)
    waves = np.array([velocity * steps @ (np.sin(omega * t) / omega) for t in time.tolist()])
    return start + 2.0 / np.pi * waves
