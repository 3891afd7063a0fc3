"""What an FMU carries by its options: the same in both backends, whose results agree to the bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from support.driven import driven
from support.fmu_instance import Instance

from m4e_fmi.errors import InputError
from m4e_fmi.fmu import ModelDescription, PythonSource, build_fmu

BACKENDS = pytest.mark.parametrize("native", [False, True], ids=["python", "native"])
STEPS = 10
STEP = 1.0  # long enough for several of the integrator

Open = Callable[..., Instance]


@pytest.fixture
def open_fmu(tmp_path: Path) -> Iterator[Open]:
    """`open_fmu(native, **options)`: an instance of the FMU of `driven` with these options."""
    with ExitStack() as stack:
        count = iter(range(100))

        def opened(native: bool, **options: Any) -> Instance:
            k = next(count)
            path = build_fmu(driven(), tmp_path / f"{k}.fmu", native=native, **options)
            assert validate_fmu(str(path)) == []
            return stack.enter_context(Instance(path, tmp_path / f"unpacked_{k}"))

        yield opened


def series(instance: Instance, *names: str, **experiment: Any) -> list[list[float]]:
    instance.initialise(**experiment)
    rows = []
    for k in range(STEPS):
        instance.step(k * STEP, STEP)
        rows.append([instance[name] for name in names])
    return rows


class TestIntegration:
    @pytest.mark.parametrize(
        "options",
        [{"method": "rk45"}, {"method": "rodas"}, {"tolerance": 2.5e-4}],
        ids=["rk45", "rodas", "tolerance"],
    )
    def test_method_and_tolerance_in_both_to_the_bit(
        self, open_fmu: Open, options: dict[str, Any]
    ) -> None:
        python, native = (series(open_fmu(n, **options), "x", "v", "a") for n in (False, True))
        assert python == native
        assert python != series(open_fmu(True), "x", "v", "a")

    @BACKENDS
    def test_the_tolerance_is_that_of_importers_who_give_none(
        self, open_fmu: Open, native: bool
    ) -> None:
        own = series(open_fmu(native, tolerance=2.5e-4), "x")
        assert own == series(open_fmu(native), "x", tolerance=2.5e-4)

    @BACKENDS
    def test_default_experiment(self, tmp_path: Path, native: bool) -> None:
        asked = {"stop_time": 3.5, "step_size": 0.25, "tolerance": 1e-6}
        path = build_fmu(driven(), tmp_path / "a.fmu", native=native, **asked)  # type: ignore[arg-type]
        description: Any = fmpy.read_model_description(str(path))
        found = description.defaultExperiment
        assert (found.stopTime, found.stepSize, found.tolerance) == ("3.5", "0.25", "1e-06")


class TestSelection:
    @BACKENDS
    def test_fewer_outputs_have_the_same_values(self, open_fmu: Open, native: bool) -> None:
        names = ["height", "energy", "x", "v", "frequency"]
        full = series(open_fmu(native), *names)
        chosen = open_fmu(native, outputs=["height", "energy"])
        assert series(chosen, *names) == full
        listed = {v.name: v.causality for v in chosen.description.modelVariables}
        assert {n for n, c in listed.items() if c == "output"} == {"height", "energy"}
        assert {n for n, c in listed.items() if c == "local"} == {
            "x", "v", "der(x)", "der(v)", "last_error",
        }  # fmt: skip

    @BACKENDS
    def test_other_names_have_the_same_values(self, open_fmu: Open, native: bool) -> None:
        full = series(open_fmu(native), "x", "energy", "a")
        table = {"x": "spring.length", "energy": "spring.energy", "mass": "m"}
        renamed = open_fmu(native, rename=table)
        assert series(renamed, "spring.length", "spring.energy", "a") == full
        derivatives = {
            v.name: v.derivative.name for v in renamed.description.modelVariables if v.derivative
        }
        assert derivatives == {
            "v": "spring.length", "a": "v", "der(spring.length)": "spring.length",
        }  # fmt: skip

    def test_errors_are_told_by_the_new_names(self, open_fmu: Open) -> None:
        instance = open_fmu(True, rename={"root": "spoilt.root"}).initialise({"x": -2.0})
        with pytest.raises(FMICallException):
            assert instance["spoilt.root"]
        assert instance.messages[-1][1].startswith("spoilt.root is ")


def test_python_code_has_no_options_of_programs(tmp_path: Path) -> None:
    source = PythonSource(ModelDescription("p", "p", ()), "slave:Slave", {}, {})
    for option in ({"outputs": ["*"]}, {"method": "rk45"}, {"rename": {"a": "b"}}):
        with pytest.raises(InputError, match="is Python code"):
            build_fmu(source, tmp_path / "p.fmu", **option)  # type: ignore[arg-type]
