"""The binary form: nothing is lost, and nothing that is wrong is taken."""

from __future__ import annotations

import ctypes
import random
import struct
import zlib

import pytest
from support.runtime_programs import chain, every_operation, van_der_pol

from m4e_fmi.errors import InputError
from m4e_fmi.program import Program, Recorder, Variable
from m4e_fmi.program.binary_form import decode, encode
from m4e_fmi.runtime.library import library


def _refusal(data: bytes) -> str:
    """The library's message, "" if it takes the program."""
    lib = library()
    assert lib is not None
    message = ctypes.create_string_buffer(200)
    program = lib.m4e_program_read(data, len(data), message, len(message))
    if program:
        lib.m4e_program_free(program)
        return ""
    assert message.value
    return message.value.decode()


def _sealed(data: bytes) -> bytes:
    """The same with the size and checksum that belong to it."""
    body = struct.pack("<Q", len(data)) + data[24:]
    return data[:12] + struct.pack("<I", zlib.crc32(body)) + body


@pytest.mark.parametrize("program", [chain(3), every_operation()], ids=lambda p: p.name)
def test_reading_gives_the_same_program(program: Program) -> None:
    data = encode(program)
    again, jacobian = decode(data)
    assert encode(again) == data
    assert jacobian == []
    assert (again.name, again.description) == (program.name, program.description)
    for group in ("parameters", "inputs", "states", "outputs", "calculated"):
        assert getattr(again, group) == getattr(program, group)


def test_every_flipped_bit_and_every_truncation_is_refused() -> None:
    data = encode(van_der_pol(5.0)[0])
    for bit in range(8 * len(data)):
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << bit % 8
        assert _refusal(bytes(flipped)), bit
        with pytest.raises(InputError):
            decode(bytes(flipped))
    for size in range(len(data)):
        assert _refusal(data[:size]), size
        with pytest.raises(InputError):
            decode(data[:size])


def test_the_library_refuses_wrong_counts_and_indices_even_under_a_right_checksum() -> None:
    data = encode(every_operation(), [(0, 0, 1)])
    rng = random.Random(3)
    taken = 0
    for _ in range(4000):
        mutant = bytearray(data)
        for _ in range(rng.randrange(1, 3)):
            word = rng.randrange(6, len(data) // 4) * 4
            value = rng.choice((0, 1, 2**31, 2**32 - 1, rng.randrange(100)))
            mutant[word : word + 4] = struct.pack("<I", value)
        sealed = _sealed(bytes(mutant))
        taken += not _refusal(sealed)
    assert 0 < taken < 4000  # start values and literals may be anything


def test_a_zero_byte_in_a_name_is_an_input_error() -> None:
    recorder = Recorder("a\0b", "")
    recorder.rate("x", -recorder.state(Variable("x", "1", "")))
    with pytest.raises(InputError, match="zero byte"):
        encode(recorder.program())
