"""The files in which an FMU carries its program: what the runtime inside it reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from zipfile import BadZipFile, ZipFile

from m4e_fmi.errors import InputError
from m4e_fmi.files.limits import LARGEST_PROGRAM
from m4e_fmi.fmu.export.selection import renamed
from m4e_fmi.program import TIME, Program, rate_entries, tangent
from m4e_fmi.program.binary_form import decode, encode

PROGRAM, TANGENT = "model.m4e", "tangent.m4e"


def model_file(program: Program, method: str, rename: Mapping[str, str]) -> bytes:
    """The program in its binary form, with what `method` needs; `rename` as in `renamed`."""
    entries = rate_entries(program) if method == "rodas" else ()
    return encode(renamed(program, rename), entries)


def carried_program(fmu: Path) -> Program | None:
    """The program that a native FMU of ours carries; None of another FMU, or of another version."""
    try:
        with ZipFile(fmu) as archive:
            info = archive.getinfo(f"resources/{PROGRAM}")
            if info.file_size > LARGEST_PROGRAM:
                return None
            return decode(archive.read(info))[0]
    except (KeyError, InputError, OSError, BadZipFile):
        return None


def tangent_file(program: Program) -> bytes:
    """Its directional derivatives in their binary form: see `tangent_program`."""
    return encode(tangent_program(program))


def tangent_program(program: Program) -> Program:
    """Directional derivatives of rates, outputs and calculated parameters, in this order.

    Directions follow the inputs: of time, states, inputs, parameters. Outputs are numbered: one may
    be a rate, and have its name.
    """
    outputs = enumerate((*program.outputs, *program.calculated))
    shown = replace(
        program,
        outputs=tuple(replace(v, name=f"y[{k}]", description=v.name) for k, v in outputs),
        results=(*program.results, *program.constants),
        calculated=(),
        constants=(),
    )
    groups = (program.states, program.inputs, program.parameters)
    return tangent(shown, along=[TIME, *(v.name for group in groups for v in group)])
