"""Units in the headers of tables: every column of every reader converts or refuses them.

A reader of tables is tested by its entry in `READERS`; one that has none fails the last test.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from support import import_graph

from m4e_adapters.hydrodynamics.config import Drift, Water
from m4e_adapters.hydrodynamics.config.waves import ComponentWaves, Record, SpectrumTable
from m4e_adapters.hydrodynamics.drift.files import read_drift
from m4e_adapters.hydrodynamics.drift.tables import MeanDrift
from m4e_adapters.hydrodynamics.seas.wave_files import read_components, read_density, read_record
from m4e_adapters.moordyn.bathymetry import bathymetry
from m4e_fmi.analysis.comparison.comparing import compare
from m4e_fmi.errors import InputError
from m4e_fmi.model import load_model
from m4e_fmi.results.compared_file import read_measured
from m4e_fmi.study.given.study import load_study
from m4e_fmi.study.programs.names import program_runs
from m4e_fmus.table.config import Config, read_rows

ROOT = Path(__file__).parents[3]
PACKAGES = {
    "m4e_fmi": ROOT / "m4e_fmi",
    "m4e_adapters": ROOT / "adapters" / "m4e_adapters",
    "m4e_fmus": ROOT / "fmus" / "m4e_fmus",
}
READING = re.compile(
    r"(?<!def )\b(read_columns|read_compared)\(|csv\.(reader|DictReader)"
    r"|\b(loadtxt|genfromtxt|read_csv|read_table)\("
)
OF_ALL = {"m4e_fmi.files.csv_columns", "m4e_fmi.results.foreign_table"}
"""Modules that read tables for the others."""

SI: dict[str, tuple[str, float]] = {
    "m": ("length", 1.0), "cm": ("length", 1e-2), "s": ("time", 1.0), "min": ("time", 60.0),
    "rad": ("angle", 1.0), "deg": ("angle", math.pi / 180.0),
    "N": ("force", 1.0), "kN": ("force", 1e3), "Hz": ("frequency", 1.0), "mHz": ("frequency", 1e-3),
    "rad/s": ("angular frequency", 1.0), "rpm": ("angular frequency", math.pi / 30.0),
    "m2/Hz": ("energy over frequency", 1.0), "cm2/Hz": ("energy over frequency", 1e-4),
    "m2.s/rad": ("energy over angular frequency", 1.0),
    "cm2.s/rad": ("energy over angular frequency", 1e-4),
    "N/m2": ("force over area", 1.0), "kN/m2": ("force over area", 1e3),
    "N.m/m2": ("moment over area", 1.0), "kN.m/m2": ("moment over area", 1e3),
}  # fmt: skip
"""Quantity and SI value of units, by hand: two of each quantity, so that columns are converted."""
BRACKETS = [*(f"[{unit}]" for unit in (*SI, "furlong", "-")), *(f"({unit})" for unit in SI)]


@dataclass(frozen=True)
class Reader:
    """A reader: its module, the `columns` of a table with the units of numbers without one.

    `rows` (n, n_columns) are in these units; `read` returns the numbers in a folder that has them
    as ``t.csv``, in any fixed unit. `also` is a quantity that any column may be, by its unit.
    """

    module: str
    columns: Mapping[str, str]
    rows: np.ndarray
    read: Callable[[Path], np.ndarray]
    also: str = "none"


def rising(count: int, width: int) -> np.ndarray:
    """Numbers (count, width) > 0, each column of which ascends in equal steps."""
    return 0.25 * (1.0 + np.arange(float(count))[:, None] + np.arange(float(width)))


def components(folder: Path) -> np.ndarray:
    found = read_components(ComponentWaves(spectrum="components", file="t.csv"), folder)
    return np.array([[c.amplitude, c.period or c.omega, c.phase, c.direction] for c in found])


def density(folder: Path) -> np.ndarray:
    found = read_density(SpectrumTable(spectrum="table", file="t.csv"), folder)
    return np.array([found.omega, found.density])


def record(folder: Path) -> np.ndarray:
    found = read_record(Record(spectrum="record", file="t.csv"), folder)
    return np.array([found.start, found.interval, *found.elevation])


def drift(folder: Path) -> np.ndarray:
    section = Drift(file="t.csv")
    found = read_drift(section, center=(0.0, 0.0, 0.0), water=Water(), folder=folder).table
    assert isinstance(found, MeanDrift)
    return np.concatenate([found.omega, found.directions, found.values.ravel()])


PLAIN = {"length": "m", "angle": "rad", "force": "N", "duration": "s", "rate": "Hz",
         "speed": "rad/s"}  # fmt: skip
"""Signals, parameters and records, and their units."""
WITH_TIME = {"time": "s", **PLAIN}


def signals(folder: Path) -> np.ndarray:
    found = read_rows(Config.model_validate({"signals": PLAIN, "file": "t.csv"}), folder)
    return np.array([found.times, *found.values.values()])


def signals_by_other_names(folder: Path) -> np.ndarray:
    keys = {"time": "time", "signals": {"f": {"unit": "kN", "column": "force"}}}
    found = read_rows(Config.model_validate({**keys, "file": "t.csv"}), folder)
    return np.array([found.times, found.values["f"]])


PARAMETERS = "".join(f"  {name}: {{value: 1, unit: {unit}}}\n" for name, unit in PLAIN.items())
MODEL = f"""\
name: pendulum
gravity: 9.81
parameters:
{PARAMETERS}bodies: {{bob: {{mass: 1, inertia: 0.1}}}}
joints: {{hinge: {{type: revolute, child: bob, joint_to_child: [0, -0.5]}}}}
"""


def tables_of_a_model(folder: Path) -> np.ndarray:
    tables = [
        f"  {name}_t: {{file: t.csv, columns: [time, {name}], unit: {unit}}}\n"
        for name, unit in PLAIN.items()
    ]
    (folder / "p.model.yaml").write_text(f"{MODEL}tables:\n{''.join(tables)}", "utf-8")
    found = load_model(folder / "p.model.yaml").tables
    return np.array([[*found["length_t"].times], *(table.values for table in found.values())])


def table_by_place(folder: Path) -> np.ndarray:
    text = f"{MODEL}tables:\n  gust: {{file: t.csv, unit: kN}}\n"
    (folder / "p.model.yaml").write_text(text, "utf-8")
    found = load_model(folder / "p.model.yaml").tables["gust"]
    return np.array([found.times, found.values])


def points(folder: Path, text: str) -> np.ndarray:
    """Values of all dimensions of a study of the model."""
    head = "name: s\nmodel: p.model.yaml\nwanted: {a: {variable: joint.hinge.q, statistic: mean}}\n"
    (folder / "p.model.yaml").write_text(MODEL, "utf-8")
    (folder / "s.yaml").write_text(head + text, "utf-8")
    axes = program_runs(load_study(folder / "s.yaml"), tell=print).named.study.grid.axes
    return np.concatenate([np.ravel(axis.points) for axis in axes])


def cases(folder: Path) -> np.ndarray:
    columns = ", ".join(f"{name}: {name}" for name in PLAIN)
    of = f"{{{columns}, simulation.stop_time: stop}}"
    return points(folder, f"table: {{file: t.csv, columns: {of}}}\n")


def compared(folder: Path) -> np.ndarray:
    head = ",".join(f"{name} [{unit}]" for name, unit in WITH_TIME.items())
    np.savetxt(folder / "ours.csv", rising(40, 7), delimiter=",", header=head, comments="")
    found = compare(folder / "ours.csv", folder / "t.csv").differences
    return np.array([[*one.time, *one.reference] for one in found.values()])


def decay(name: str) -> Callable[[Path], np.ndarray]:
    def read(folder: Path) -> np.ndarray:
        found = read_measured(folder / "t.csv", name)
        return np.array([found.time, found.values])

    return read


def seabed(folder: Path) -> np.ndarray:
    found = bathymetry("t.csv", folder=folder)
    return np.array([*found.x, *found.y, *found.depth.flat])


WAVES = "m4e_adapters.hydrodynamics.seas.wave_files"
BY_PERIOD = {"amplitude": "m", "period": "s", "phase": "rad", "direction": "deg"}
BY_OMEGA = {"amplitude": "m", "omega": "rad/s", "phase": "rad", "direction": "deg"}
OF_DRIFT = {"omega": "rad/s", "direction": "deg"} | dict.fromkeys(("surge", "sway"), "N/m2")
RECORD = np.stack([0.5 * np.arange(40.0), np.sin(np.arange(40.0))], 1)
CASES = {**PLAIN, "stop": "s"}
CSV = "m4e_fmus.table.config"
OF_MODELS = "m4e_fmi.model.yaml"
SPECTRUM = {"omega": "rad/s", "density": "m2.s/rad"}
BED = "m4e_adapters.moordyn.bathymetry"
GRID = np.array([[1.0, 1.0, 3.0], [1.0, 2.0, 4.0], [2.0, 1.0, 5.0], [2.0, 2.0, 6.0]])
DRIFT = np.array([[0.5, 0.0, 1.0, 2.0, 3.0], [1.5, 0.0, 4.0, 5.0, 6.0]])
COMPARING, MEASURED = "m4e_fmi.analysis.comparison.comparing", "m4e_fmi.results.compared_file"
READERS = {
    "wave components": Reader(WAVES, BY_PERIOD, rising(3, 4), components),
    "wave components over omega": Reader(WAVES, BY_OMEGA, rising(3, 4), components),
    "spectrum": Reader(WAVES, SPECTRUM, rising(4, 2), density),
    "spectrum over frequency": Reader(
        WAVES, {"frequency": "Hz", "density": "m2/Hz"}, rising(4, 2), density
    ),
    "record of waves": Reader(WAVES, {"time": "s", "elevation": "m"}, RECORD, record),
    "drift": Reader(
        "m4e_adapters.hydrodynamics.drift.files", {**OF_DRIFT, "yaw": "N.m/m2"}, DRIFT, drift
    ),
    "seabed": Reader(BED, {"x": "m", "y": "m", "depth": "m"}, GRID, seabed),
    "signals": Reader(CSV, WITH_TIME, rising(4, 7), signals),
    "signals by other names": Reader(
        CSV, {"force": "kN", "time": "s"}, rising(4, 2), signals_by_other_names
    ),
    "tables of a model": Reader(OF_MODELS, WITH_TIME, rising(4, 7), tables_of_a_model),
    "table by place": Reader(OF_MODELS, {"t": "s", "F": "kN"}, rising(4, 2), table_by_place),
    "cases of a study": Reader("m4e_fmi.study.given.tables", CASES, rising(3, 7), cases),
    "compared": Reader(COMPARING, WITH_TIME, rising(40, 7), compared),
    "decay": Reader(MEASURED, {"time": "s", "heave": "m"}, RECORD, decay("heave"), "angle"),
}


def write(folder: Path, heads: Sequence[str], rows: np.ndarray) -> None:
    lines = [",".join(map(repr, row)) for row in rows.tolist()]
    (folder / "t.csv").write_text("\n".join([",".join(heads), *lines, ""]), "utf-8")


@pytest.mark.parametrize(
    ("name", "column"), [(name, column) for name, one in READERS.items() for column in one.columns]
)
def test_a_unit_in_a_header_is_converted_or_refused(name: str, column: str, tmp_path: Path) -> None:
    reader = READERS[name]
    heads, place = list(reader.columns), list(reader.columns).index(column)
    quantity, factor = SI[reader.columns[column]]
    assert sum(other == quantity for other, _ in SI.values()) > 1
    write(tmp_path, heads, reader.rows)
    plain = reader.read(tmp_path)
    for brackets in BRACKETS:
        heads[place] = f"{column} {brackets}"
        given, given_factor = SI.get(brackets[1:-1], ("", 1.0))
        rows = reader.rows.copy()
        if given == quantity:
            rows[:, place] *= factor / given_factor
            write(tmp_path, heads, rows)
            found = reader.read(tmp_path)
            np.testing.assert_allclose(found, plain, rtol=1e-12, atol=1e-12, err_msg=brackets)
        elif given != reader.also:
            write(tmp_path, heads, rows)
            with pytest.raises(InputError) as caught:
                print(brackets, reader.read(tmp_path))
            for problem in caught.value.problems:
                assert Path(problem.file).suffix in (".csv", ".yaml"), (brackets, problem)
                assert re.search(rf"\b{column}\b", problem.message), (brackets, problem)
                assert problem.remedy, (brackets, problem)


def test_optional_columns_of_wave_components(tmp_path: Path) -> None:
    """Those of another meaning are ignored; phases are not, however their name is written."""
    heads = ["amplitude", "period", "phase_speed", "directional_spread"]
    write(tmp_path, heads, rising(3, 4))
    assert {*components(tmp_path)[:, 2:].flat} == {None}
    for name in ("Phase [deg]", "PHASE", "phase (degrees)"):
        write(tmp_path, [*heads[:2], name, "direction"], rising(3, 4))
        with pytest.raises(InputError, match="no column 'phase'"):
            components(tmp_path)


@pytest.mark.parametrize(("head", "rows", "columns"), [
    ("d", 1.0, 1.0), ("d [cm]", 0.01, 1.0), ("d [m/s]", None, None),
    ("length [cm] / duration [min]", 0.01, 60.0), ("length (cm)\\duration (min)", 0.01, 60.0),
    *((head, None, None) for head in (
        "duration [min] / length [cm]", "length / duration [min]", "length [cm] / duration",
        "length [cm] / duration [furlong]", "length [furlong] / duration [s]")),
])  # fmt: skip
def test_units_of_a_scatter_diagram(
    head: str, rows: float | None, columns: float | None, tmp_path: Path
) -> None:
    (tmp_path / "t.csv").write_text(f"{head},5,7\n1,10,20\n2,30,40\n", "utf-8")
    text = "simulation: {stop_time: 1}\nscatter: {file: t.csv, rows: length, columns: duration}\n"
    if rows is None or columns is None:
        with pytest.raises(InputError, match=re.escape(head)) as caught:
            points(tmp_path, text)
        assert all(problem.remedy for problem in caught.value.problems)
    else:
        expected = [rows, 2.0 * rows, 5.0 * columns, 7.0 * columns]
        np.testing.assert_allclose(points(tmp_path, text), expected, rtol=1e-15)


def test_all_readers_of_tables_are_in_the_list() -> None:
    modules = import_graph.modules(PACKAGES)
    found = {name for name, file in modules.items() if READING.search(file.read_text("utf-8"))}
    assert OF_ALL < found <= OF_ALL | {reader.module for reader in READERS.values()}
