"""Context of a group of checks: the library, facts about the FMU, random values."""

from __future__ import annotations

import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.validation.fmu_under_test import FmuUnderTest, scale, start, within
from m4e_fmi.fmu.validation.library import Library
from m4e_fmi.fmu.validation.probe import Probe

SEED = 20
PATIENCE = 8.0
"""Seconds after which a group leaves out repetitions, for FMUs that are slow to start or step."""


@dataclass(frozen=True)
class Facts:
    """Results of the first group: inputs may vary by `amplitude` times their scale, `works` names
    the declared capabilities that are really there."""

    amplitude: float = 0.0
    works: tuple[str, ...] = ()


@dataclass
class Context:
    """One group's process: `folder` is for files that the next group reads.

    `pace` is by how much inputs and communication steps are smaller than the FMU's own, `holds`
    whether its values hold between steps of a solver inside: see `pace`.
    """

    subject: FmuUnderTest
    library: Library
    facts: Facts
    folder: Path
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(SEED))
    began: float = field(default_factory=time.monotonic)
    pace: float = 1.0
    holds: bool = False

    @property
    def step_size(self) -> float:
        """The communication step to go by [s]."""
        return self.pace * self.subject.step_size

    @property
    def late(self) -> bool:
        """True if the group has taken longer than PATIENCE."""
        return time.monotonic() - self.began > PATIENCE

    @contextmanager
    def probe(
        self, *, exchange: bool = False, name: str = "validation"
    ) -> Generator[Probe, None, None]:
        """An instance that is freed afterwards, whatever happened."""
        probe = self.library.probe(exchange=exchange, name=name)
        try:
            yield probe
        finally:
            probe.free()

    def random_inputs(self, count: int = 1) -> np.ndarray:
        """Random continuous inputs (count, n_inputs), in their units.

        Declared derivatives of inputs stay 0.
        """
        held = [v.derivative is not None for v in self.subject.inputs]
        values = self.random(self.subject.inputs, count)
        values[:, held] = 0.0
        return values

    def random(self, variables: list[ModelVariable], count: int = 1) -> np.ndarray:
        """Random values (count, n_variables) around the start values and in the limits, in SI."""
        size = self.pace * self.facts.amplitude * np.array([scale(v) for v in variables])
        middle = np.array([start(v) for v in variables])
        values = middle + size * self.rng.uniform(-1, 1, (count, len(variables)))
        for k, variable in enumerate(variables):
            values[:, k] = [within(variable, value) for value in values[:, k]]
        return values

    def run(self, probe: Probe, inputs: np.ndarray, size: float) -> list[np.ndarray]:
        """Values of all Reals at the start and after each step, each (n_reals,), in their units.

        Each step has one row of `inputs` (n_steps, n_inputs), in their units, and `size` [s].
        """
        seen = [probe.read(self.subject.readable)]
        for row in inputs:
            probe.put(self.subject.inputs, row)
            probe.advance(size)
            seen.append(probe.read(self.subject.readable))
        return seen


def first_difference(
    subject: FmuUnderTest, one: list[np.ndarray], other: list[np.ndarray]
) -> tuple[int, list[str]] | None:
    """Row of the first difference of two runs, bit by bit, and the variables that differ there.

    `one` and `other` are lists of rows (n_reals,), in the variables' units.
    """
    for k, (a, b) in enumerate(zip(one, other, strict=True)):
        if a.tobytes() != b.tobytes():
            differs = a.view(np.uint64) != b.view(np.uint64)
            return k, [v.name for v, d in zip(subject.readable, differs, strict=True) if d]
    return None
