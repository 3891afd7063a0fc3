"""Hydrodynamic data as a file has them, in one form for all formats.

Values are per density: A/ρ, B/ρ, X/(ρg), K/(ρg), since WAMIT's files do not have the density. Waves
are e^{−iωt}, directions those that waves travel to, from +X towards +Y, and motions the six of
`geometry.motions.SPACE` of each body about its reference point, as of `coefficients`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError

SIX = 6
KEYS = ("coefficients",)
"""Where a configuration names the file."""
Point = tuple[float, float, float]


@dataclass(frozen=True)
class FileBody:
    """A body of a file; None is what the file does not have.

    Attributes
    ----------
    name : as in the file, else body1, body2, …
    stiffness : (6, 6) K/(ρg) [m2, m3, m4] about the reference point, of a body that weighs what it
        displaces, at the centre of gravity of the file.
    missing : motions that the file does not have; their values are 0.
    reference, center_of_gravity, center_of_buoyancy : (x, y, z) [m].
    volume : displaced [m3].
    """

    name: str
    stiffness: np.ndarray
    missing: tuple[str, ...] = ()
    reference: Point | None = None
    center_of_gravity: Point | None = None
    center_of_buoyancy: Point | None = None
    volume: float | None = None


@dataclass(frozen=True)
class FileData:
    """Content of a file (or of some that belong together) of N bodies, n = 6 N motions.

    Attributes
    ----------
    omega : (nω,) angular frequencies [rad/s]; as read any order, 0 and inf included.
    added_mass, damping : (nω, n, n) A/ρ [m3, m4, m5] and B/ρ [m3/s, …]: [force, motion].
    added_mass_inf : (n, n) A∞/ρ, if the file has it.
    directions : (nβ,) [deg].
    excitation : (nω, nβ, n) X/(ρg) [m2, m3], complex; NaN at frequencies where the file has none.
    density [kg/m3], gravity [m/s2], depth [m] : None where the file does not have it.
    notes : what is to be told of the reading.
    """

    path: Path
    format: str
    bodies: tuple[FileBody, ...]
    omega: np.ndarray
    added_mass: np.ndarray
    damping: np.ndarray
    added_mass_inf: np.ndarray | None
    directions: np.ndarray
    excitation: np.ndarray
    density: float | None = None
    gravity: float | None = None
    depth: float | None = None
    notes: tuple[str, ...] = ()

    def chosen(self, rows: np.ndarray) -> FileData:
        """The data at some frequencies: `rows` (k,), indices or booleans."""
        return replace(
            self,
            omega=self.omega[rows],
            added_mass=self.added_mass[rows],
            damping=self.damping[rows],
            excitation=self.excitation[rows],
        )

    def with_notes(self, *notes: str) -> FileData:
        """The data with more notes."""
        return replace(self, notes=(*self.notes, *notes))


def refused(message: str, remedy: str = "") -> InputError:
    """The error of a file as a whole, placed where the configuration names it."""
    return InputError.single(message, remedy, keys=KEYS)
