"""The FMU under test: what its description says, in the form in which the checks need it."""

from __future__ import annotations

import math
from dataclasses import dataclass
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


@dataclass(frozen=True)
class FmuUnderTest:
    """The FMU unpacked into `folder`; `raw` is its description as FMPy reads it.

    Of FMI 3.0, the description is that of the elements: see `elements`.
    """

    folder: Path
    raw: FmpyDescription

    @classmethod
    def read(cls, folder: Path) -> FmuUnderTest:
        """The FMU unpacked into `folder`; TooLargeError beyond MOST_ELEMENTS."""
        return cls.of(folder, fmpy.read_model_description(str(folder), validate=False))

    @classmethod
    def of(cls, folder: Path, raw: FmpyDescription) -> FmuUnderTest:
        """The same from FMPy's reading of the description; TooLargeError beyond MOST_ELEMENTS."""
        count = sum(math.prod(v.shape or ()) for v in raw.modelVariables)
        if count > MOST_ELEMENTS:
            limit = f"at most {MOST_ELEMENTS:,} are looked at"
            message = f"it has {count:,} variables, elements of arrays included; {limit}"
            raise TooLargeError(message)
        if raw.fmiVersion != "3.0":
            return cls(folder, raw)
        # FMPy makes a variable of each <Alias>: another name, but no further value
        raw.modelVariables = [v for v in raw.modelVariables if v.alias is None]
        return cls(folder, flattened(raw, (folder / MODEL_DESCRIPTION).read_bytes()))

    @property
    def fmi_3(self) -> bool:
        """True if it is of FMI 3.0."""
        return self.raw.fmiVersion == "3.0"

    @cached_property
    def array_starts(self) -> dict[int, np.ndarray]:
        """Start values (n_elements,) of arrays by value reference, in their units."""
        found: dict[int, list[float]] = {}
        for variable in self.reals():
            found.setdefault(owner(variable), []).append(start(variable))
        return {reference: np.array(values) for reference, values in found.items()}

    @property
    def steps(self) -> bool:
        """True if it is for co-simulation."""
        return self.raw.coSimulation is not None

    @property
    def exchanges(self) -> bool:
        """True if it is for model exchange."""
        return self.raw.modelExchange is not None

    @property
    def ways(self) -> tuple[bool, ...]:
        """False for co-simulation, True for model exchange: those that it is for."""
        return (False,) * self.steps + (True,) * self.exchanges

    @property
    def kinds(self) -> list[CoSimulation | ModelExchange]:
        """FMPy's co-simulation and model exchange, as far as it is for them."""
        return [k for k in (self.raw.coSimulation, self.raw.modelExchange) if k is not None]

    def kind(self, *, exchange: bool) -> CoSimulation | ModelExchange:
        """The one of `kinds` for model exchange or for co-simulation."""
        return self.raw.modelExchange if exchange else self.raw.coSimulation

    @property
    def step_size(self) -> float:
        """The communication step to test with [s]: that declared, or a usual one."""
        return self.declared_step or DEFAULT_STEP

    @cached_property
    def declared_step(self) -> float | None:
        """The step of the default experiment, or that inside [s]; None if there is neither."""
        experiment = self.raw.defaultExperiment
        stepping = self.raw.coSimulation
        texts = [experiment.stepSize] if experiment is not None else []
        texts += [stepping.fixedInternalStepSize] if stepping is not None else []
        sizes = [float(text) for text in texts if text]
        return next((s for s in sizes if s > 0 and math.isfinite(s)), None)

    @property
    def start_time(self) -> float:
        """Start time [s] of the default experiment, 0 where there is none."""
        experiment = self.raw.defaultExperiment
        return float((experiment.startTime if experiment is not None else None) or 0.0)

    @property
    def variable_steps(self) -> bool:
        """True if communication steps may be of any size."""
        return self.steps and bool(self.raw.coSimulation.canHandleVariableCommunicationStepSize)

    def reals(self, *causalities: str) -> list[ModelVariable]:
        """Reals of these causalities; of all without any."""
        return [
            v
            for v in self.raw.modelVariables
            if v.type == "Real" and (not causalities or v.causality in causalities)
        ]

    @cached_property
    def inputs(self) -> list[ModelVariable]:
        """Continuous inputs of type Real."""
        return [v for v in self.reals("input") if v.variability == "continuous"]

    @cached_property
    def outputs(self) -> list[ModelVariable]:
        """Continuous outputs of type Real."""
        return [v for v in self.reals("output") if v.variability == "continuous"]

    @cached_property
    def readable(self) -> list[ModelVariable]:
        """Every Real that has a value of its own at any time."""
        return [v for v in self.reals() if v.causality != "independent"]

    @cached_property
    def rates(self) -> list[ModelVariable]:
        """The derivatives of the continuous states, in the order of the states."""
        return [unknown.variable for unknown in self.raw.derivatives]

    @cached_property
    def states(self) -> list[ModelVariable]:
        """The continuous states."""
        return [cast(ModelVariable, rate.derivative) for rate in self.rates]

    @cached_property
    def given(self) -> list[ModelVariable]:
        """The Reals whose start value may be set: inputs, parameters, initial="exact"."""
        return [
            v
            for v in self.readable
            if v.causality in ("input", "parameter")
            or (v.initial == "exact" and v.variability != "constant")
        ]


def scale(variable: ModelVariable) -> float:
    """The size of the values that a Real is made for."""
    size = nominal(variable)
    return size if size is not None and size > 0 else abs(start(variable)) or 1.0


def nominal(variable: ModelVariable) -> float | None:
    """The nominal value of a Real, from itself or its declared type."""
    value = declared_number(variable, "nominal", math.nan)
    return None if math.isnan(value) else value


def start(variable: ModelVariable) -> float:
    """The start value of a Real, 0 where there is none."""
    value = float(variable.start or 0.0)
    return value if math.isfinite(value) else 0.0


def within(variable: ModelVariable, value: float) -> float:
    """`value`, moved into the limits of the Real."""
    low, high = limits(variable)
    return float(np.clip(value, low, high)) if low <= high else value


def limits(variable: ModelVariable) -> tuple[float, float]:
    """min and max of a Real, from itself or its declared type; infinite where there is none."""
    low = declared_number(variable, "min", -math.inf)
    return low, declared_number(variable, "max", math.inf)
