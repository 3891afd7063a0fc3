"""What a study takes from the outcome of a run."""

from __future__ import annotations

import hashlib
import math
import pickle
from dataclasses import replace
from pathlib import Path

from support.small_study import written_study

import m4e_fmi
from m4e_fmi.cosim import prepare
from m4e_fmi.cosim.connections.links import Port
from m4e_fmi.cosim.error_estimate.report import CouplingError, CouplingErrorReport
from m4e_fmi.study.given.study import Wanted
from m4e_fmi.study.runs.record import Record
from m4e_fmi.study.systems.task import Blob, Task, coupling_error_of, perform


def test_the_coupling_error_is_the_one_that_a_single_run_tells() -> None:
    """What switches a step earlier is off by its whole jump, and says nothing of the others."""
    switch = CouplingError("a -> b", Port("a", "y"), 1.0, 0.5, 20.0, switched=True)
    motion = CouplingError("b -> a", Port("b", "x"), 0.02, 0.01, 1.0)
    report = CouplingErrorReport((switch, motion))
    assert str(report).startswith("largest coupling error 2.0e-02")
    assert coupling_error_of(report) == (0.02, "b.x")
    assert math.isnan(coupling_error_of("not known")[0])


def blob_of(path: Path) -> Blob:
    """The content of a file."""
    return Blob(hashlib.sha256(path.read_bytes()).hexdigest(), path.name, path)


def test_outputs_beyond_their_limits_are_told_also_if_nothing_is_wanted_of_them(
    tmp_path: Path,
) -> None:
    """As in a single run, which records all outputs."""
    written_study(tmp_path, "")
    system = m4e_fmi.load_system(tmp_path / "system.yaml")
    prepared = prepare(system, build_directory=tmp_path / "build")
    cart = prepared.descriptions["cart"]
    limited = replace(cart.variables["body.cart.x"], maximum=0.1)  # it begins at 0.2 m
    cart = replace(cart, variables={**cart.variables, limited.name: limited})
    prepared = replace(prepared, descriptions={**prepared.descriptions, "cart": cart})
    (tmp_path / "prepared").write_bytes(pickle.dumps(prepared))
    fmus = {name: blob_of(d.path) for name, d in prepared.descriptions.items()}
    wanted = (Wanted("force", "pto.force", "maximum"),)
    given = blob_of(tmp_path / "prepared")
    found = perform(Task("k", given, fmus, {}, 0.1, wanted, (), 0.0, certify=False))
    assert isinstance(found, Record)
    assert not found.failure
    (told,) = found.warnings
    assert told.startswith("cart.body.cart.x is 0.2 m at t = 0 s, outside -inf to 0.1 m")
