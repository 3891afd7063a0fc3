"""The radiation memory K(t) of coupled motions from their damping: T. F. Ogilvie's (1964)

    K(t) = (2/π) ∫₀^∞ B(ω) cos ωt dω.

B is a cubic spline through its data, less what is negative in them, and 0 at ω = 0; beyond the last
of them it falls as ω⁻ᵖ.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from m4e_adapters.hydrodynamics.memory.group_data import GroupData

NODES = 6  # of Gauss in each step of the frequencies, which spans at most half a wave of cos ωt
POWERS = (3, 5, 7, 9)  # of the tail; 3 is that of excitation as ω⁻³, 7 that of a heaving half-ball


@dataclass(frozen=True)
class Kernel:
    """K(t) of m motions.

    Attributes
    ----------
    nodes : (k,) [rad/s], those of a quadrature over the data.
    damping : (k, m, m) [N.s/m, N.s, N.m.s], B there times the weights of the quadrature [rad/s].
    end : frequency [rad/s] where the tail begins.
    last : (m, m) [N.s/m, N.s, N.m.s], B there, that of the tail.
    longest : time [s] up to which the frequencies, by their spacing, tell the memory.
    power : p of the tail [1].
    """

    nodes: np.ndarray
    damping: np.ndarray
    end: float
    last: np.ndarray
    longest: float
    power: int = POWERS[0]

    @classmethod
    def of(cls, data: GroupData) -> Kernel:
        """The kernel of the trusted data, with the tail that agrees best with A(ω)."""
        from scipy.interpolate import CubicSpline

        trusted = data.known.all(axis=1)
        omega = np.append(0.0, data.omega[trusted])
        values = _positive(data.damping[trusted], data.scale)
        half = 0.5 * np.diff(omega)
        places, weights = np.polynomial.legendre.leggauss(NODES)
        nodes = (omega[:-1, None] + half[:, None] * (1.0 + places)).ravel()
        spline = CubicSpline(omega, np.concatenate([np.zeros_like(values[:1]), values]))
        plain = cls(
            nodes=nodes,
            damping=spline(nodes) * (half[:, None] * weights).reshape(-1, 1, 1),
            end=float(omega[-1]),
            last=values[-1],
            longest=np.pi / float(np.median(2.0 * half)),
        )
        return replace(plain, power=plain._best_power(data))

    def at(self, time: np.ndarray) -> np.ndarray:
        """K (n, m, m) [N/m, N, N.m] at `time` (n,) [s] ≥ 0."""
        return self._of_data(time) + self._of_tail(time)

    def _of_data(self, time: np.ndarray) -> np.ndarray:
        waves = np.cos(np.outer(time, self.nodes))
        return (2.0 / np.pi) * np.tensordot(waves, self.damping, axes=1)

    def _of_tail(self, time: np.ndarray) -> np.ndarray:
        return (2.0 / np.pi) * self._tail(time)[:, None, None] * self.last

    def _best_power(self, data: GroupData) -> int:
        """That of the tail with which A(ω) − A∞ varies most as B says."""
        time = np.linspace(0.0, self.longest, 1 + 4 * int(self.longest * self.end))
        steps = np.full(len(time), time[1])
        steps[[0, -1]] *= 0.5
        trusted = data.known.all(axis=1)
        omega, given = data.omega[trusted], data.added_mass[trusted]
        waves = np.sin(np.outer(omega, time)) * steps / omega[:, None]
        size = np.sqrt(np.outer(data.inertia, data.inertia))
        known = self._of_data(time)

        def apart(power: int) -> float:
            memory = known + replace(self, power=power)._of_tail(time)
            mass = -np.tensordot(waves, memory, axes=1)
            return float(((given - mass).std(axis=0) / size).sum())

        return min(POWERS, key=apart)

    def _tail(self, time: np.ndarray) -> np.ndarray:
        """∫ (end/ω)ᵖ cos ωt dω from the end on, (n,) [rad/s], at `time` (n,) [s]."""
        from scipy.special import exp1

        z = 1j * np.maximum(self.end * time, 1e-9)
        found = exp1(z)
        for k in range(1, self.power):
            found = (np.exp(-z) - z * found) / k
        return self.end * found.real


def _positive(matrices: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Symmetric `matrices` (n, m, m) without their negative parts; `scale` (m, m) is their unit."""
    values, vectors = np.linalg.eigh(matrices / scale)
    return (vectors * np.maximum(values, 0.0)[:, None]) @ vectors.swapaxes(1, 2) * scale
