"""Versions of components: as few FMUs as there are different programs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest
from support.small_study import written_study

from m4e_fmi.cosim import load_system
from m4e_fmi.cosim.input_checks.drafts import Draft, drafted
from m4e_fmi.cosim.system.component import Component
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program
from m4e_fmi.study.systems.variants import MOST_DRAFTS, Combination, Variants, variants

Keys = list[tuple[str | int, ...]]
Changed = Callable[[Program], Program]
DAMPING: Keys = [("damping",)]
BOTH: Keys = [("damping",), ("stiffness",)]


def found(
    folder: Path, name: str, keys: Keys, wanted: list[Combination], changed: Changed | None = None
) -> Variants:
    """The versions of a component, whose programs are `changed` if that is given."""
    written_study(folder, "name: none\n")
    system = load_system(folder / "system.yaml")

    def make(component: Component) -> Draft:
        draft = drafted(system, component)
        assert isinstance(draft.made, Program)
        return replace(draft, made=changed(draft.made)) if changed else draft

    return variants(system, name, keys, wanted, make)


def start_of(program: Program, name: str) -> float:
    return next(v.start for v in program.parameters if v.name == name)


def test_keys_that_are_start_values_share_one_fmu(tmp_path: Path) -> None:
    one = found(tmp_path, "pto", BOTH, list(product(range(1, 11), repeat=2)))
    assert len(one.builds) == 1
    assert one.of[7, 9].start == {"damping": 7.0, "stiffness": 9.0}
    assert one.of[1, 1].start == {}
    assert one.labels[0][0] == "N.s/m"
    # the rest length follows from the point, and is a parameter
    one = found(tmp_path, "pto", [("point_at", 1)], [(-1,), (-1.5,), (-1.2,)])
    assert len(one.builds) == 1
    assert one.of[-1.5,].start["rest_length"] == pytest.approx((1 + 0.25) ** 0.5)


def test_other_operations_have_an_fmu_of_their_own(tmp_path: Path) -> None:
    """Few drafts wait for their FMUs: of a sea in space hundreds would fill the memory."""
    one = found(tmp_path, "push", [("times", 1)], [(0.1 * k,) for k in range(1, 15)])
    assert [variant.build for variant in one.of.values()] == [*range(14)]
    assert [*one.drafts] == [*range(MOST_DRAFTS)]


def test_all_values_that_a_section_refuses_are_told_together(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        found(tmp_path, "pto", BOTH, [(-3, 1), (1, -4), (-5, 1)])
    assert "with damping = -3" in str(caught.value)
    assert "stiffness = -4" in str(caught.value)


def test_a_key_that_is_a_start_value_up_to_a_threshold(tmp_path: Path) -> None:
    """At one of 40 values alone, between others, the section makes another program."""

    def bent(program: Program) -> Program:
        damping = start_of(program, "damping")
        return program.with_start({"damping": 25.0}) if damping == 28.0 else program

    wanted: list[Combination] = [(d,) for d in range(1, 41)]
    one = found(tmp_path, "pto", DAMPING, wanted, bent)
    starts = {d: one.of[d,].start.get("damping", 1.0) for (d,) in wanted}
    assert starts == {d: 25.0 if d == 28 else d for (d,) in wanted}
    assert one.labels == {}  # the parameter is not the key


def test_a_key_in_degrees_is_not_labelled_in_radians(tmp_path: Path) -> None:
    """At the first value, 0, both are equal."""

    def in_radians(program: Program) -> Program:
        return program.with_start({"damping": start_of(program, "damping") / 57.3})

    assert found(tmp_path, "pto", DAMPING, [(0.0,), (30.0,)], in_radians).labels == {}
