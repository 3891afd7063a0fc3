"""Record of an FMI 3.0 instance that the C library shares: see the runtime's component_3.h."""

from __future__ import annotations

import ctypes
from ctypes import c_double, c_int32, c_uint64, c_void_p


class RawComponent(ctypes.Structure):
    """`m4e_component_3`; Python keeps its own record of the instance in it, too.

    Times are in seconds: `next_event` is announced, `reached` that of the last step, `ended` that
    of the end the FMU asked for; infinite if there is none.
    """

    _fields_ = [
        ("instance", c_void_p),
        ("do_step", c_void_p),
        ("enter_event_mode", c_void_p),
        ("update_discrete_states", c_void_p),
        ("enter_step_mode", c_void_p),
        ("get_state", c_void_p),
        ("set_state", c_void_p),
        ("has_events", c_int32),
        ("stepping", c_int32),
        ("goes_on", c_int32),
        ("next_event", c_double),
        ("reached", c_double),
        ("ended", c_double),
        ("interruptions", c_uint64),
        ("handled", c_uint64),
        ("begin_step", c_void_p),
    ]
    next_event: float
    ended: float
    goes_on: int
    interruptions: int
    handled: int


class RawState(ctypes.Structure):
    """`m4e_state_3`."""

    _fields_ = [
        ("state", c_void_p),
        ("next_event", c_double),
        ("reached", c_double),
        ("ended", c_double),
        ("interruptions", c_uint64),
    ]


EVENT_FIELDS = ("next_event", "reached", "ended", "interruptions")
"""Fields that a saved state has of its component."""
