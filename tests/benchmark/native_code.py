"""Compiles and loads the C and C++ files of `native/`; libraries are kept in build/benchmark."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
from collections.abc import Sequence
from ctypes import c_double, c_long, c_void_p
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmark.engine import Batch, UnavailableError

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "benchmark"
NATIVE = Path(__file__).with_name("native")

Floats = NDArray[np.float64]


def compiled(source: Path, options: Sequence[str], *, plus_plus: bool = False) -> ctypes.CDLL:
    """The library made from one source file. Raises UnavailableError with the compiler's words."""
    variable, candidates = ("CXX", ("c++", "g++")) if plus_plus else ("CC", ("cc", "gcc"))
    found = (shutil.which(name) for name in (os.environ.get(variable, ""), *candidates) if name)
    compiler = next((path for path in found if path), None)
    if compiler is None:
        raise UnavailableError(f"no {'C++' if plus_plus else 'C'} compiler ({candidates[0]})")
    command = [compiler, "-shared", "-fPIC", "-DNDEBUG", f"-I{NATIVE}", str(source), *options]
    headers = [path.read_bytes() for path in sorted(NATIVE.glob("*.h"))]
    content = [source.read_bytes(), *headers, " ".join(command).encode()]
    digest = hashlib.sha256(b"\0".join(content)).hexdigest()[:16]
    target = BUILD / f"{source.stem}-{digest}.so"
    if not target.exists():
        BUILD.mkdir(parents=True, exist_ok=True)
        part = target.with_suffix(f".{os.getpid()}")
        run = subprocess.run(
            [*command, "-o", str(part)], capture_output=True, text=True, check=False
        )
        if run.returncode:
            errors = [line for line in run.stderr.splitlines() if "error" in line]
            raise UnavailableError(f"{source.name} does not compile: {(errors or [''])[0][:200]}")
        part.replace(target)
    try:
        return ctypes.CDLL(str(target))
    except OSError as error:
        raise UnavailableError(f"{source.name} does not load: {error}") from error


def native_batch(
    function: int, self: int | None, x: Floats, *, results: int = 0, owner: object = None
) -> Batch:
    """Batch of a C function `void f(void *self, double t, const double *x, double *result)`.

    `function` and `self` are addresses, `owner` is what must live as long as they are used; the
    result has as many numbers as x, or `results`.
    """
    loop = compiled(NATIVE / "loop.c", ["-O2"])
    loop.loop_seconds.restype = c_double
    loop.loop_seconds.argtypes = [c_void_p, c_void_p, c_void_p, c_void_p, c_long]
    result = np.empty(results or x.size)
    kept = (loop, owner)

    def batch(calls: int) -> float:
        return kept[0].loop_seconds(function, self, x.ctypes.data, result.ctypes.data, calls)

    return batch


def address(library: ctypes.CDLL, name: str) -> int:
    """Address of a function of a library."""
    found = ctypes.cast(getattr(library, name), c_void_p).value
    assert found is not None
    return found


def interleaved(q: Sequence[float], u: Sequence[float]) -> Floats:
    """q and u of each link in turn: the state that the C functions know."""
    x = np.empty(2 * len(q))
    x[0::2], x[1::2] = q, u
    return x


def call_rates(function: int, self: int | None, q: Sequence[float], u: Sequence[float]) -> Floats:
    """u̇ from a C function of the form that `native_batch` takes."""
    kind = ctypes.CFUNCTYPE(None, c_void_p, c_double, c_void_p, c_void_p)
    x = interleaved(q, u)
    rates = np.empty_like(x)
    kind(function)(self, 0.0, x.ctypes.data, rates.ctypes.data)
    return rates[1::2]
