"""The FMU under test: what its description says, in the form in which the checks need it."""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path
from typing import cast

import fmpy
import numpy as np
from fmpy import fmi2, fmi3
from fmpy.model_description import CoSimulation, ModelExchange, ModelVariable

from m4e_fmi.fmu.importer.elements import FmpyDescription, flattened, owner
from m4e_fmi.fmu.importer.opening import MODEL_DESCRIPTION
from m4e_fmi.fmu.importer.reading import declared_number

CLASSES = {
    "2.0": (fmi2.FMU2Slave, fmi2.FMU2Model),
    "3.0": (fmi3.FMU3Slave, fmi3.FMU3Model),
}
"""FMPy's for co-simulation and for model exchange, with all functions as methods."""
DEFAULT_STEP = 0.01  # s, where the FMU names none

WRITTEN = 5e-6
"""Relative error of a number written with six digits, as C's %g does."""


MOST_ELEMENTS = 50_000
"""Variables, arrays counted by their elements, of FMUs that are looked at beyond FMPy's rules."""


class TooLargeError(Exception):
    """The FMU has more variables and elements of arrays than are looked at."""


class FmuUnderTest:
    """The FMU unpacked into `folder`; `raw` is its description as FMPy reads it.

    Of FMI 3.0, the description is that of the elements: see `elements`. It `steps` in
    co-simulation, and `exchanges` in model exchange; `ways` are False and True for these, `kinds`
    FMPy's records of them. `variable_steps` says that communication steps may be of any size,
    `declared_step` [s] is the step of the default experiment, or that inside, None if there is
    neither, and `step_size` [s] the one to test with; `start_time` [s] is that of the experiment.

    Of the Reals, `inputs` and `outputs` are the continuous ones, `readable` those that have a value
    of their own at any time, `given` those whose start value may be set (inputs, parameters,
    initial="exact"), `rates` the derivatives of the continuous `states`, in their order.

    TooLargeError beyond MOST_ELEMENTS.
    """

    def __init__(self, folder: Path, raw: FmpyDescription = None) -> None:
        raw = raw or fmpy.read_model_description(str(folder), validate=False)
        count = sum(math.prod(v.shape or ()) for v in raw.modelVariables)
        if count > MOST_ELEMENTS:
            limit = f"at most {MOST_ELEMENTS:,} are looked at"
            message = f"it has {count:,} variables, elements of arrays included; {limit}"
            raise TooLargeError(message)
        self.fmi_3 = raw.fmiVersion == "3.0"
        if self.fmi_3:
            # FMPy makes a variable of each <Alias>: another name, but no further value
            raw.modelVariables = [v for v in raw.modelVariables if v.alias is None]
            raw = flattened(raw, (folder / MODEL_DESCRIPTION).read_bytes())
        self.folder, self.raw = folder, raw
        self.steps, self.exchanges = raw.coSimulation is not None, raw.modelExchange is not None
        self.ways = (False,) * self.steps + (True,) * self.exchanges
        self.kinds: list[CoSimulation | ModelExchange] = [self.kind(exchange=e) for e in self.ways]
        stepping, experiment = raw.coSimulation, raw.defaultExperiment
        texts = [experiment.stepSize] if experiment is not None else []
        texts += [stepping.fixedInternalStepSize] if self.steps else []
        sizes = [float(text) for text in texts if text]
        self.declared_step = next((s for s in sizes if s > 0 and math.isfinite(s)), None)
        self.step_size = self.declared_step or DEFAULT_STEP
        begin = experiment.startTime if experiment is not None else None
        self.start_time = float(begin or 0.0)
        self.variable_steps = self.steps and bool(stepping.canHandleVariableCommunicationStepSize)
        self.reals: list[ModelVariable] = [v for v in raw.modelVariables if v.type == "Real"]
        continuous = [v for v in self.reals if v.variability == "continuous"]
        self.inputs = [v for v in continuous if v.causality == "input"]
        self.outputs = [v for v in continuous if v.causality == "output"]
        self.readable = [v for v in self.reals if v.causality != "independent"]
        self.rates: list[ModelVariable] = [unknown.variable for unknown in raw.derivatives]
        self.states = [cast(ModelVariable, rate.derivative) for rate in self.rates]
        self.given = [
            v
            for v in self.readable
            if v.causality in ("input", "parameter")
            or (v.initial == "exact" and v.variability != "constant")
        ]

    def kind(self, *, exchange: bool) -> CoSimulation | ModelExchange:
        """FMPy's record for model exchange or for co-simulation."""
        return self.raw.modelExchange if exchange else self.raw.coSimulation

    @cached_property
    def array_starts(self) -> dict[int, np.ndarray]:
        """Start values (n_elements,) of arrays by value reference, in their units."""
        found: dict[int, list[float]] = {}
        for variable in self.reals:
            found.setdefault(owner(variable), []).append(start(variable))
        return {reference: np.array(values) for reference, values in found.items()}


def scale(variable: ModelVariable) -> float:
    """The size of the values that a Real is made for."""
    size = declared_number(variable, "nominal", math.nan)
    return size if size > 0 else abs(start(variable)) or 1.0


def start(variable: ModelVariable) -> float:
    """The start value of a Real, 0 without a finite one."""
    value = float(variable.start or 0.0)
    return value if math.isfinite(value) else 0.0


def within(variable: ModelVariable, value: float) -> float:
    """`value`, moved into the limits of the Real."""
    low, high = limits(variable)
    return float(np.clip(value, low, high)) if low <= high else value


def limits(variable: ModelVariable) -> tuple[float, float]:
    """min and max of a Real, from itself or its declared type; infinite if not declared."""
    low = declared_number(variable, "min", -math.inf)
    return low, declared_number(variable, "max", math.inf)
