"""Versions of components: as few FMUs as there are different programs."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.small_study import written_study

from m4e_fmi.cosim import load_system
from m4e_fmi.cosim.input_checks.drafts import Draft, drafted
from m4e_fmi.cosim.system.component import Component
from m4e_fmi.errors import InputError
from m4e_fmi.study.systems.variants import Combination, Variants, variants

Keys = list[tuple[str | int, ...]]


def found(folder: Path, name: str, keys: Keys, wanted: list[Combination]) -> tuple[Variants, int]:
    """The versions of a component, and the number of programs that were made for them."""
    written_study(folder, "name: none\n")
    system = load_system(folder / "system.yaml")
    made: list[Component] = []

    def make(component: Component) -> Draft:
        made.append(component)
        return drafted(system, component)

    return variants(system, name, keys, wanted, make), len(made)


def test_keys_that_are_start_values_share_one_fmu(tmp_path: Path) -> None:
    wanted: list[Combination] = [(d, s) for d in range(1, 21) for s in range(1, 21)]
    one, count = found(tmp_path, "pto", [("damping",), ("stiffness",)], wanted)
    assert len(one.builds) == 1
    assert count < 60  # of 400 sections
    assert one.of[7, 9].start == {"damping": 7.0, "stiffness": 9.0}
    assert one.of[1, 1].start == {}
    assert one.labels[0][0] == "N.s/m"


def test_keys_that_are_other_start_values_share_one_fmu(tmp_path: Path) -> None:
    """The rest length follows from the point, and is a parameter."""
    one, _ = found(tmp_path, "pto", [("point_at", 1)], [(-1,), (-1.5,), (-1.2,)])
    assert len(one.builds) == 1
    assert one.of[-1.5,].start["rest_length"] == pytest.approx((1 + 0.25) ** 0.5)


def test_other_operations_have_an_fmu_of_their_own(tmp_path: Path) -> None:
    one, _ = found(tmp_path, "push", [("between",)], [("linear",), ("held",)])
    assert [variant.build for variant in one.of.values()] == [0, 1]


def test_values_that_a_section_refuses_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="with damping = -3"):
        found(tmp_path, "pto", [("damping",)], [(1,), (-3,)])
