"""Declarations of m4e.h for ctypes. Standard library only: it also travels inside FMUs."""

from __future__ import annotations

import ctypes
from ctypes import (
    POINTER,
    c_char_p,
    c_double,
    c_int,
    c_int32,
    c_size_t,
    c_uint32,
    c_uint64,
    c_void_p,
)
from pathlib import Path

ABI = 6
LANES = 8
METHODS = {"rk45": 0, "dop853": 1, "rodas": 2, "rk4": 3}
BLOCKS = {"rates": 0, "outputs": 1, "derivatives": 2, "watched": 3, "timely": 4}


def snapshot_size(states: int) -> int:
    """Numbers that `m4e_keep` writes of so many states: M4E_KEPT of m4e.h."""
    return 4 + 10 * states


class Counts(ctypes.Structure):
    """`m4e_counts` of m4e.h."""

    _fields_ = [
        (name, c_uint32)
        for name in (
            "states", "inputs", "parameters", "outputs", "calculated",
            "nodes", "literals", "entries", "hoisted", "timely",
        )
    ]  # fmt: skip


class OptionsStruct(ctypes.Structure):
    """`m4e_options` of m4e.h."""

    _fields_ = [
        ("method", c_int32),
        ("rtol", c_double),
        ("atol", c_double),
        ("max_step", c_double),
        ("max_steps", c_uint64),
        ("quadratures", c_uint64),
    ]


class ReportStruct(ctypes.Structure):
    """`m4e_report` of m4e.h."""

    _fields_ = [
        ("status", c_int32),
        ("component", c_int32),
        ("time", c_double),
        ("step", c_double),
        ("evaluations", c_uint64),
        ("jacobians", c_uint64),
        ("accepted", c_uint64),
        ("rejected", c_uint64),
        ("rows", c_uint64),
        ("events", c_uint64),
    ]


class Events(ctypes.Structure):
    """`m4e_events` of m4e.h."""

    _fields_ = [
        ("count", c_uint32),
        ("direction", c_void_p),
        ("terminal", c_void_p),
        ("capacity", c_uint64),
        ("index", c_void_p),
        ("time", c_void_p),
        ("state", c_void_p),
    ]


class BlockStruct(ctypes.Structure):
    """`m4e_block` of m4e.h."""

    _fields_ = [
        ("code", c_void_p),
        ("length", c_uint64),
        ("result", c_void_p),
        ("results", c_uint32),
        ("registers", c_uint32),
        ("timely", c_uint32),
        ("kernel", c_void_p),
    ]


_DOUBLES = c_void_p  # address of a contiguous array
_SIGNATURES: dict[str, tuple[object, ...]] = {
    "m4e_abi": (c_int,),
    "m4e_program_read": (c_void_p, c_char_p, c_size_t, c_char_p, c_size_t),
    "m4e_program_free": (None, c_void_p),
    "m4e_program_counts": (None, c_void_p, POINTER(Counts)),
    "m4e_model_new": (c_void_p, c_void_p, c_uint32, c_uint32, c_void_p, c_uint32, c_void_p),
    "m4e_model_free": (None, c_void_p),
    "m4e_model_block": (POINTER(BlockStruct), c_void_p, c_int),
    "m4e_set_parameters": (None, c_void_p, _DOUBLES),
    "m4e_set_inputs": (None, c_void_p, _DOUBLES),
    "m4e_rates": (None, c_void_p, c_double, _DOUBLES, _DOUBLES),
    "m4e_outputs": (None, c_void_p, c_double, _DOUBLES, _DOUBLES),
    "m4e_calculated": (None, c_void_p, _DOUBLES),
    "m4e_jacobian": (c_int, c_void_p, c_double, _DOUBLES, _DOUBLES),
    "m4e_integrator_new": (c_void_p, c_void_p, POINTER(OptionsStruct), POINTER(Events)),
    "m4e_integrator_free": (None, c_void_p),
    "m4e_start": (None, c_void_p, c_double, _DOUBLES, c_double),
    "m4e_advance": (
        c_int, c_void_p, c_double, c_size_t, _DOUBLES, _DOUBLES, POINTER(ReportStruct),
    ),
    "m4e_go_on": (
        c_int, c_void_p, c_double, _DOUBLES, c_double, c_int, c_double, POINTER(c_int32),
        POINTER(ReportStruct),
    ),
    "m4e_keep": (None, c_void_p, _DOUBLES),
    "m4e_take_up": (None, c_void_p, _DOUBLES),
    "m4e_ensemble": (
        c_int, c_void_p, POINTER(OptionsStruct), c_size_t, _DOUBLES, _DOUBLES, _DOUBLES, c_size_t,
        _DOUBLES, _DOUBLES, _DOUBLES, POINTER(ReportStruct),
    ),
    "m4e_instruction_set": (c_char_p,),
}  # fmt: skip


def load(path: Path) -> ctypes.CDLL:
    """The library at `path`; OSError if it cannot be loaded, or is of another version."""
    loaded = ctypes.CDLL(str(path))
    for name, (result, *arguments) in _SIGNATURES.items():
        function = getattr(loaded, name)
        function.restype, function.argtypes = result, arguments
    if loaded.m4e_abi() != ABI:
        raise OSError(f"{path} has another interface version than this m4e_fmi")
    return loaded
