"""Runs of a system: keys of kept ones, FMUs of others, what is taken from a run, the order."""

from __future__ import annotations

import hashlib
import math
import pickle
import shutil
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from unittest.mock import patch

import pytest
from support.small_study import SYSTEM, Here, written_study

import m4e_fmi
from m4e_fmi.code_hash import package_hash
from m4e_fmi.cosim import load_system, prepare
from m4e_fmi.cosim.error.report import CouplingError, CouplingErrorReport
from m4e_fmi.cosim.preparation.components import Draft, drafted
from m4e_fmi.cosim.system.component import Component
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Port
from m4e_fmi.program import Program
from m4e_fmi.study import StudyOutcome, run_study
from m4e_fmi.study.given.study import Wanted
from m4e_fmi.study.record import Record
from m4e_fmi.study.systems.task import Blob, Task, coupling_error_of, perform
from m4e_fmi.study.systems.variants import Combination, Variants, variants

STUDY = """\
name: carts
system: system.yaml
start_up: 0
simulation: {stop_time: 0.1}
vary: {cart.k: [30]}
wanted:
  y: {variable: own.y, statistic: maximum}
"""
OWN = """\
import helper_of_own


class Own:
    outputs = {"y": "1"}

    def step(self, t, h, v):
        return {"y": helper_of_own.value()}
"""
HELPER = "import second_of_own\n\n\ndef value():\n    return second_of_own.VALUE\n"


def test_modules_that_python_code_leads_to_are_part_of_the_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They do not travel in the FMU, whose content stays as it is."""
    modules = tmp_path / "modules"
    modules.mkdir()
    monkeypatch.syspath_prepend(modules)
    system = SYSTEM.replace("  push:", "  own: {kind: python, file: own.py}\n  push:")
    study = written_study(tmp_path, STUDY, system=system)
    (tmp_path / "own.py").write_text(OWN, "utf-8")
    (modules / "helper_of_own.py").write_text(HELPER, "utf-8")
    kept = []
    for value in (1, 25, 25):
        (modules / "second_of_own.py").write_text(f"VALUE = {value}\n", "utf-8")
        package_hash.cache_clear()  # as another process would find it
        outcome = run_study(study, build_directory=tmp_path / "build", executor=Here())
        assert not outcome.failures
        kept.append(outcome.kept)
    package_hash.cache_clear()
    assert kept == [0, 0, 1]


Fmus = Callable[[str], Path]


def made(folder: Path, component: str, fmu: Path, study: str) -> StudyOutcome:
    """A study of one FMU as a `component`, in 5 steps of 0.2 s."""
    shutil.copy(fmu, folder / "own.fmu")
    (folder / "system.yaml").write_text(
        f"name: s\ncomponents: {{{component}: {{fmu: own.fmu}}}}\n"
        "simulation: {stop_time: 1, step_size: 0.2, algorithm: jacobi}\n",
        "utf-8",
    )
    path = folder / "study.yaml"
    path.write_text(f"name: s\nsystem: system.yaml\nstart_up: 0\n{study}", "utf-8")
    return run_study(path, build_directory=folder / "build", executor=Here())


def test_a_run_that_an_fmu_ends_before_the_stop_time_is_told(c_fmu: Fmus, tmp_path: Path) -> None:
    """Its statistics are of a shorter record."""
    study = (
        "vary: {fuse.when: [0.4, 9]}\nwanted: {y: {variable: fuse.y, statistic: maximum}}\n"
        "series: [fuse.y]\n"
    )
    outcome = made(tmp_path, "fuse", c_fmu("ending"), study)
    ends = [record.time[-1] for record in outcome.records]
    assert ends == pytest.approx([0.4, 1.0])
    told = "the run ended before its stop time of 1 s: fuse requested the end of the simulation"
    (line,) = (w for w in outcome.warnings if w.startswith(told))
    assert line.endswith("at t = 0.4 s")
    assert outcome.warnings[line] == 1


def test_a_varied_structural_parameter_sizes_the_arrays_of_each_run(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    study = (
        "start: {g.gain: 2}\nvary: {g.size: [3, 5]}\n"
        'wanted: {y: {variable: "g.y[3]", statistic: maximum}}\n'
    )
    outcome = made(tmp_path, "g", c_fmu("3:gallery"), study)
    assert not outcome.failures
    alone = made(tmp_path, "g", c_fmu("3:gallery"), study.replace("[3, 5]", "[5]"))
    assert alone.kept == 1
    assert alone.data["y"].values == outcome.data["y"].values[1]


def test_the_coupling_error_is_the_one_that_a_single_run_tells() -> None:
    """What switches a step earlier is off by its whole jump, and says nothing of the others."""
    switch = CouplingError("a -> b", Port("a", "y"), 1.0, 0.5, 20.0, switched=True)
    motion = CouplingError("b -> a", Port("b", "x"), 0.02, 0.01, 1.0)
    report = CouplingErrorReport((switch, motion))
    assert str(report).startswith("largest coupling error 2 % of the range of 1, at b.x")
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
    prepared = replace(prepared, descriptions={**prepared.descriptions, "cart": cart}).recording()
    (tmp_path / "prepared").write_bytes(pickle.dumps(prepared))
    fmus = {name: blob_of(d.path) for name, d in prepared.descriptions.items()}
    wanted = (Wanted("force", "pto.force", "maximum"),)
    given = blob_of(tmp_path / "prepared")
    found = perform(Task("k", given, fmus, {}, 0.1, wanted, (), 0.0, certify=False))
    assert isinstance(found, Record)
    assert not found.failure
    (told,) = found.warnings
    assert told.startswith("cart.body.cart.x is 0.2 m at t = 0 s, outside -inf to 0.1 m")


Keys = list[tuple[str | int, ...]]
Changed = Callable[[Program], Program]
BOTH: Keys = [("damping",), ("stiffness",)]


def found(
    folder: Path, name: str, keys: Keys, wanted: list[Combination], changed: Changed | None = None
) -> Variants:
    """The versions of a component, whose programs are `changed` if that is given."""
    written_study(folder, "name: none\n")
    system = load_system(folder / "system.yaml")

    def make(of: System, component: Component) -> Draft:
        draft = drafted(of, component)
        assert isinstance(draft.made, Program)
        return replace(draft, made=changed(draft.made)) if changed else draft

    with patch("m4e_fmi.study.systems.variants.drafted", make):
        return variants(system, name, keys, wanted)


def test_keys_that_are_start_values_share_one_fmu(tmp_path: Path) -> None:
    one = found(tmp_path, "pto", BOTH, list(product(range(1, 11), repeat=2)))
    assert len(one.builds) == 1
    assert one.of[7, 9].start == {"damping": 7.0, "stiffness": 9.0}
    assert one.of[1, 1].start == {}
    assert [one.label(k)[0] for k in (0, 1)] == ["N.s/m", "N/m"]
    # the rest length follows from the point, and is a parameter
    one = found(tmp_path, "pto", [("point_at", 1)], [(-1,), (-1.5,), (-1.2,)])
    assert len(one.builds) == 1
    assert one.of[-1.5,].start["rest_length"] == pytest.approx((1 + 0.25) ** 0.5)


def test_other_operations_have_an_fmu_of_their_own(tmp_path: Path) -> None:
    one = found(tmp_path, "push", [("times", 1)], [(0.1 * k,) for k in range(1, 15)])
    assert [variant.build for variant in one.of.values()] == [*range(14)]


@pytest.mark.parametrize("at", [0.0, 28.0])
def test_a_key_that_is_another_start_value_at_one_of_many(tmp_path: Path, at: float) -> None:
    """Between others, or at the first; the parameter is not the key, and has no label of it."""

    def bent(program: Program) -> Program:
        damping = next(v.start for v in program.parameters if v.name == "damping")
        return program.with_start({"damping": 25.0}) if damping == at else program

    wanted: list[Combination] = [(d,) for d in range(41)]
    one = found(tmp_path, "pto", BOTH[:1], wanted, bent)
    first = 25.0 if at == 0.0 else 0.0
    starts = {d: one.of[d,].start.get("damping", first) for (d,) in wanted}
    assert starts == {d: 25.0 if d == at else d for (d,) in wanted}
    assert one.label(0) == ("", "")
