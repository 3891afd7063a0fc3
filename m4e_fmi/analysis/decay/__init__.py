"""Free decay: period, linear and quadratic damping of a recorded motion, with standard errors.

Imports nothing of `m4e_fmi.analysis`. Start with `fit`; `record` checks a record and finds its
peaks, `oscillation` is the model, `correlated` has the standard errors, `notes` the doubts.
"""

from m4e_fmi.analysis.decay.fit import Decay, Estimate, fit_decay
from m4e_fmi.analysis.decay.notes import decay_notes
from m4e_fmi.analysis.decay.record import Peaks, Window

__all__ = ["Decay", "Estimate", "Peaks", "Window", "decay_notes", "fit_decay"]
