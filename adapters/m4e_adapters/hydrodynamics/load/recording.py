"""Recording of the load part by part, in the order in which a program computes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import BodyPoint, Current, Drag, Loads
from m4e_adapters.hydrodynamics.drift.bodies import record_drifts, shown_motions
from m4e_adapters.hydrodynamics.drift.tables import BodyDrift
from m4e_adapters.hydrodynamics.load.body_points import OnBody, points_on_bodies, record_air_gaps
from m4e_adapters.hydrodynamics.load.drag import (
    InWater,
    bodies_in_moving_water,
    record_drag,
    record_water_velocity,
)
from m4e_adapters.hydrodynamics.load.matched_sea import MatchedSea
from m4e_adapters.hydrodynamics.load.motions import Motions
from m4e_adapters.hydrodynamics.load.outputs import (
    publish_added_mass,
    record_displacement,
    record_outputs,
)
from m4e_adapters.hydrodynamics.load.parts import record_hydrostatics, record_memory
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory
from m4e_adapters.hydrodynamics.seas.sea import HullsInSea, RecordedSea, RecordSea
from m4e_fmi.program import Program, Recorder, Scalar

Vector = list[Scalar | float]


@dataclass(frozen=True)
class Recording:
    """A load being recorded: bodies whose motions are `moved`, the `sea`, and the `loads` that act.

    Without `memory` no radiation acts.
    """

    recorder: Recorder
    coefficients: Coefficients
    moved: Motions
    sea: MatchedSea
    loads: Loads
    memory: RadiationMemory | None

    def program(
        self,
        record_sea: RecordSea,
        drags: Mapping[str, Drag],
        current: Current | None,
        drifts: Mapping[str, BodyDrift],
        points: Mapping[str, BodyPoint],
    ) -> Program:
        """All parts of the load, and the outputs; arguments as of `hydrodynamics_program`."""
        recorder, coefficients, moved = self.recorder, self.coefficients, self.moved
        parts: dict[str, Vector] = {}
        if self.memory is not None:
            groups = self.memory.groups
            parts["radiation"] = record_memory(recorder, groups, coefficients, moved.velocity)
        on_bodies = points_on_bodies(coefficients, points)
        has_drag = self.loads.drag != "none"
        in_water = bodies_in_moving_water(coefficients, drags, current) if has_drag else ()
        waves = self._waves(record_sea, on_bodies, in_water)
        if excited_by := coefficients.excited_by:
            whole = excited_by[0] if len(excited_by) == 1 else "excitation"
            parts[whole] = waves.excitation
        if self.loads.hydrostatics != "none":
            restoring = record_hydrostatics(recorder, coefficients, moved.displacement)
            parts = {"hydrostatic": restoring, **parts}
        if has_drag:
            water = record_water_velocity(
                recorder, coefficients, current, moved, in_water, waves.velocities
            )
            parts["drag"] = record_drag(recorder, coefficients, drags, moved.velocity, water)
        if drifts:
            parts["drift"] = record_drifts(
                recorder, drifts, self.sea.drifts, waves.waves, coefficients, moved
            )
        self._record_bodies(parts, drifts)
        record_air_gaps(recorder, coefficients, moved, on_bodies, waves.levels)
        self._publish_added_mass()
        return recorder.program()

    def _waves(
        self, record_sea: RecordSea, on_bodies: Sequence[OnBody], in_water: Sequence[InWater]
    ) -> RecordedSea:
        """The waves: at bodies, at points for air gaps, and where drag acts.

        Where bodies are displaced, they meet the waves of where they have come to.
        """
        coefficients, moved = self.coefficients, self.moved
        offsets = moved.offsets(coefficients) if self.loads.displaced else []
        waters = [body.place(coefficients, moved.reference, offsets) for body in in_water]
        hulls = HullsInSea(
            self.sea.directed,
            heading=moved.axes.angle if moved.axes else 0.0,
            places=moved.places,
            gauges=[point.place(coefficients, moved.reference) for point in on_bodies],
            waters=waters,
            offsets=offsets,
        )
        return record_sea(self.recorder, self.sea.systems, coefficients, hulls)

    def _record_bodies(self, parts: Mapping[str, Vector], drifts: Mapping[str, BodyDrift]) -> None:
        """Wrench, its parts and displacement of each body."""
        coefficients, axes = self.coefficients, self.moved.axes
        held = () if self.loads.displaced else self.sea.systems
        for k, body in enumerate(coefficients.bodies):
            own = coefficients.own(k)
            shown = shown_motions(drifts.get(body), coefficients)
            acts = {name: part[own] for name, part in parts.items()}
            record_outputs(self.recorder, body, coefficients, acts, axes, drifts=shown)
            displacement = self.moved.displacement[own]
            record_displacement(self.recorder, body, coefficients, displacement, k, held)

    def _publish_added_mass(self) -> None:
        """Added mass at infinite frequency: variable outputs where the heading turns."""
        if self.memory is None:
            return
        turns = self.sea.heading.filter_time
        publish = self.recorder.output if turns else self.recorder.calculate
        matrix = self.memory.added_mass_inf
        publish_added_mass(publish, self.coefficients, matrix, self.moved.axes)
