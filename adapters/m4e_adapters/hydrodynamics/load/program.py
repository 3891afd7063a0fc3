"""The hydrodynamic load on floating bodies as a Program.

    F = F_b − K ξ − ∫ K(t − τ) v(τ) dτ + r(t) Re Σ X a_k e^{−i(ω_k t + φ_k)} − c |v| v + F_d

about each body's centre of gravity, world frame: ξ is the displacement (surge, heave, pitch) from
the reference pose, v its rate, F_b the buoyancy in the reference pose, r the ramp, F_d the drift
of second order (see `drift`). The dry weight
and A∞ times the acceleration are *not* in F: both belong to whoever holds the body's mass, to whom
A∞ is published as `added_mass[i,j]`.

In space all this is in axes turned about Z by the heading h, in which ξ has the yaw ψ − h and, for
roll and pitch, the rotation vector R_z(ψ − h) (φ, θ, 0): R_z(ψ) R_y(θ) R_x(φ) turns by it, but for
terms of the third order (of the second about Z, which no force depends on).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import (
    AnyWaves,
    BodyPoint,
    Current,
    Drag,
    Loads,
    Radiation,
)
from m4e_adapters.hydrodynamics.drift.tables import BodyDrift
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_adapters.hydrodynamics.load.matched_sea import matched_sea
from m4e_adapters.hydrodynamics.load.motions import record_motions
from m4e_adapters.hydrodynamics.load.recording import Recording
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory, fit_radiation
from m4e_adapters.hydrodynamics.seas.sea import RecordSea, record_sea
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program, Recorder


def _silent(_: str) -> None:
    pass


def hydrodynamics_program(
    coefficients: Coefficients,
    *,
    name: str = "hydrodynamics",
    waves: AnyWaves | None = None,
    drag: Mapping[str, Drag] | None = None,
    current: Current | None = None,
    radiation: Radiation | None = None,
    heading: Heading | None = None,
    loads: Loads | None = None,
    drift: Mapping[str, BodyDrift] | None = None,
    points: Mapping[str, BodyPoint] | None = None,
    sea: RecordSea = record_sea,
    memory: RadiationMemory | None = None,
    folder: Path = Path(),
    progress: Callable[[str], object] = _silent,
) -> Program:
    """The load on all bodies of `coefficients`, from any source of these.

    Parameters
    ----------
    waves : in directions that `coefficients` are for; None: still water.
    drag : drag by body name; bodies left out start with none (it stays tunable).
    current : of the water, which drag is relative to.
    radiation : kind and order of the radiation memory; None: a state space, automatic.
    heading : of the hulls, in space; None: 0.
    loads : the parts of the load that act; None: all. Those of the excitation must be what
        `coefficients` have (`excited_by`).
    drift : second-order drift by body name.
    points : of bodies, whose air gaps are outputs.
    sea : records the waves and gives the excitation of each motion.
    memory : of the radiation; None: it is fitted.
    folder : where files of the waves are.
    progress : is told the accuracy of the memory.

    Returns
    -------
    Program
        Inputs `<body>.{x,z,theta,vx,vz,omega}` of the centre of gravity, outputs
        `<body>.{force_x,force_z,moment_y}` about it, `wave.elevation`, and the parts
        `<body>.hydrostatic_…`, `radiation_…`, `excitation_…`, `drag_…`, `drift_…` of the force. In
        space also the inputs `<body>.{y,phi,psi,vy,omega_x,omega_z}` and `force_y`, `moment_x`,
        `moment_z`.
    """
    acting = loads or Loads()
    _check_excitation(coefficients, acting)
    matched = matched_sea(
        coefficients,
        waves=waves,
        drift=drift or {},
        heading=heading or Heading(),
        folder=folder,
        progress=progress,
    )
    recorder = Recorder(name, f"linear hydrodynamics of {', '.join(coefficients.bodies)}")
    moved = record_motions(recorder, coefficients, matched.heading)
    acts = acting.radiation != "none"
    fitted = memory or _fitted(coefficients, radiation or Radiation(), progress) if acts else None
    recording = Recording(recorder, coefficients, moved, matched, acting, fitted)
    return recording.program(sea, drag or {}, current, drift or {}, points or {})


def _fitted(
    coefficients: Coefficients, radiation: Radiation, progress: Callable[[str], object]
) -> RadiationMemory:
    """The radiation memory that is asked for."""
    convolution = radiation.memory == "convolution"
    return fit_radiation(
        coefficients, order=radiation.order, convolution=convolution, progress=progress
    )


def _check_excitation(coefficients: Coefficients, loads: Loads) -> None:
    """InputError if the excitation of `coefficients` consists of other parts than those of `loads`.

    The whole excitation, as files have it, cannot be divided without the part that is left out.
    """
    if coefficients.excited_by != loads.excitation:
        wanted, known = (
            " and ".join(p) or "none" for p in (loads.excitation, coefficients.excited_by)
        )
        raise InputError.single(
            f"the loads have {wanted} of the excitation, the coefficients {known} as a whole",
            "switch froude_krylov and diffraction on, or give coefficients with their parts",
            keys=("loads",),
        )
