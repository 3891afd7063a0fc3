"""The paper's error measure, Eqs. (9) to (11), as written.

S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody", section 4.2.
"""

from __future__ import annotations

import numpy as np

THRESHOLD = 1e-4
"""Smallest value to normalise by [m or rad]: the tolerance of the authors' reference solver."""


def body_errors(motion: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """NRMSE_b of every body, from x, z, θ of all bodies in columns, (K, 3N).

    Of each column the RMS of the error over its largest magnitude; of each body the root of the sum
    of squares over its columns.
    """
    largest = np.maximum(np.abs(reference).max(axis=0), THRESHOLD)  # Eq. 9
    rms = np.sqrt(np.mean(((motion - reference) / largest) ** 2, axis=0))  # Eq. 10
    return np.sqrt((rms.reshape(-1, 3) ** 2).sum(axis=1))  # Eq. 11
