"""Seeds of all families of files: valid ones, and the commands that read them."""

from __future__ import annotations

import io
import json
import struct
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from support import defects, packages, paper_listings
from support.chrono_files import chrono_model
from support.chrono_mechanisms import spatial_mechanism
from support.flap_file import TEXT, WAVE
from support.fuzz.archives import packed
from support.runtime_programs import every_operation, robertson

from m4e_fmi.cosim.ssp.package import Package
from m4e_fmi.errors import M4eError
from m4e_fmi.files.document import Document
from m4e_fmi.fmu.importer.opening import check_archive
from m4e_fmi.program.binary_form import encode
from m4e_fmi.results.results_file import write_netcdf
from m4e_fmi.results.row_file import CELLS, MAGIC, ResultColumn, RowFile, RowSection
from m4e_fmi.results.series import Recorded

ROOT = Path(__file__).parents[3]
Files = Mapping[str, bytes]
Check = Callable[[Path], object]


@dataclass(frozen=True)
class Seed:
    """Files, of which the first is read; each command has its path in place of FILE."""

    name: str
    files: Files
    commands: tuple[tuple[str, ...], ...]
    damaged: tuple[str, ...] = ()
    """Names of those that are damaged; the first if there are none."""


@dataclass(frozen=True)
class Family:
    """Files of one kind: how many cases a campaign has, seeds, and the first check of a file.

    The check raises M4eError, or is false, for a file that is none of this kind at all.
    """

    name: str
    cases: int
    make: Callable[[], Iterable[Seed]]
    first: Check

    @cached_property
    def seeds(self) -> tuple[Seed, ...]:
        """All seeds; some take a run to make."""
        return tuple(self.make())

    def passes(self, path: Path) -> bool:
        """True if a file gets past the first check of its readers."""
        try:
            return self.first(path) is not False
        except (M4eError, OSError, UnicodeError):
            return False


# ---- YAML ----


def _models() -> Iterator[Seed]:
    read = (("info", "FILE"), ("equations", "FILE"))
    simulate = (("simulate", "FILE", "--stop-time", "0.01", "--no-plot"),)
    for path in sorted((ROOT / "examples").rglob("*.model.yaml")):
        small = path.stat().st_size < 2500
        commands = (*read[:1], *(simulate if small else ()), *(read[1:] if small else ()))
        yield Seed(path.stem, {"a.model.yaml": path.read_bytes()}, commands)
    flap = {"flap.model.yaml": TEXT.encode(), "wave.csv": WAVE.encode()}
    yield Seed("flap", flap, (read[0], *simulate), tuple(flap))
    lists = paper_listings.spiderfloat()
    lists["Force"].pop("CG")
    text = _json(lists).replace(b"NaN", b"null")
    yield Seed("lists", {"lists.yaml": text}, read[:1])
    yield Seed("chrono", {"chrono.yaml": _json(chrono_model(lists))}, read[:1])
    arm = _json(spatial_mechanism("UNIVERSAL", 0))
    yield Seed("chrono in space", {"chrono.yaml": arm}, read[:1])


def _json(data: object) -> bytes:
    def plain(value: Any) -> Any:
        return value.tolist() if isinstance(value, np.ndarray) else float(value)

    return json.dumps(data, default=plain, indent=1).encode()


TABLES = """name: tables
components:
  wind: {kind: table, file: wind.csv, signals: {speed: m/s}}
  all: {kind: sum, unit: m/s, inputs: [a, b]}
connections: [wind.speed -> all.a]
simulation: {stop_time: 1, step_size: 0.1}
"""
FMUS = """name: fmus
components:
  one: {fmu: one.fmu, start: {mass: 3}}
  two: {fmu: one.fmu}
connections: [one.load -> two.force]
outputs: {x: two.x}
simulation: {stop_time: 1, step_size: 0.1, algorithm: jacobi}
"""
SET = "name: light\nvalues: {one.mass: 2, one.damping: 0.1, two.on: true, two.text: a}\n"


def _systems() -> Iterator[Seed]:
    load = (("load_system", "FILE"),)
    for path in sorted((ROOT / "examples").rglob("system.yaml")):
        if path.parent.name != "hydraulic_pto":  # whose kinds may not be installed
            models = {p.name: p.read_bytes() for p in path.parent.glob("*.model.yaml")}
            files = {path.name: path.read_bytes(), **models}
            yield Seed(f"system {path.parent.name}", files, load, (path.name,))
    files = {"system.yaml": TABLES.encode(), "wind.csv": b"time,speed\n0,1\n1,2\n"}
    yield Seed("system tables", files, (*load, ("make", "FILE")), tuple(files))
    files = {"system.yaml": FMUS.encode(), "one.fmu": _fmu(defects.description())}
    yield Seed("system fmus", files, (*load, ("info", "FILE")))
    yield Seed("parameters", {"set.yaml": SET.encode()}, (("parameters", "FILE"),))


# ---- archives ----

FMI_3 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="a" instantiationToken="a">
<CoSimulation modelIdentifier="a" canHandleVariableCommunicationStepSize="true"/>
<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>
<DefaultExperiment startTime="0" stopTime="1" stepSize="0.1"/>
<ModelVariables>
<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
<UInt64 name="n" valueReference="1" causality="structuralParameter" variability="fixed" start="3"/>
<Float64 name="u" valueReference="2" causality="input" start="1 2 3"><Dimension valueReference="1"/>
</Float64>
<Float64 name="y" valueReference="3" causality="output" unit="m"><Alias name="z"/></Float64>
<Boolean name="b" valueReference="4" causality="parameter" variability="fixed" start="true"/>
<String name="s" valueReference="5" causality="parameter" variability="fixed"><Start value="a"/></String>
</ModelVariables>
<ModelStructure><Output valueReference="3" dependencies="2"/>
<InitialUnknown valueReference="3"/></ModelStructure></fmiModelDescription>
"""  # noqa: E501
TERMINALS = """<?xml version="1.0" encoding="UTF-8"?>
<fmiTerminalsAndIcons fmiVersion="3.0"><Terminals><Terminal name="t" matchingRule="plug">
<TerminalMemberVariable variableName="u" memberName="u" variableKind="signal"/>
</Terminal></Terminals></fmiTerminalsAndIcons>
"""


def _fmu(text: str, library: str = f"{fmpy.platform}/{defects.NAME}", **more: str) -> bytes:
    """An FMU whose library is empty: it can be read, but not be loaded."""
    library = f"binaries/{library}{fmpy.sharedLibraryExtension}"
    return packed({defects.XML: text, library: b"", **more})


def _fmus() -> Iterator[Seed]:
    read = (("info", "FILE"), ("info", "--json", "FILE"), ("describe", "FILE"))
    check = (("validate", "--only", "description", "FILE"),)
    yield Seed("fmi 2", {"a.fmu": _fmu(defects.description())}, (*read, *check))
    more = {"terminalsAndIcons/terminalsAndIcons.xml": TERMINALS}
    three = _fmu(FMI_3, f"{fmpy.platform_tuple}/a", **more)
    yield Seed("fmi 3", {"a.fmu": three}, (*read, *check))


def _packages() -> Iterator[Seed]:
    load = (("load_system", "FILE"),)
    inside = {"SystemStructure.ssd": _ssd(), "resources/one.fmu": _fmu(defects.description())}
    yield Seed("ssp", {"a.ssp": packed(inside)}, load)
    source = 'type="application/x-ssp-parameter-set" source="set.ssv"'
    mapping = '<ssd:ParameterMapping type="application/x-ssp-parameter-mapping" source="map.ssm"/>'
    bindings = (
        f"<ssd:ParameterBindings><ssd:ParameterBinding {source}>{mapping}</ssd:ParameterBinding>"
        "</ssd:ParameterBindings>"
    )
    inside |= {
        "SystemStructure.ssd": _ssd(bindings),
        "set.ssv": packages.parameter_set({"m": 'Real value="2" unit="N"'}, packages.UNITS),
        "map.ssm": packages.parameter_mapping({"mass": "m"}),
    }
    yield Seed("ssp parameters", {"a.ssp": packed(inside)}, load)
    values = packages.parameter_set({"one.mass": 'Real value="2"', "one.name": 'String value="a"'})
    yield Seed("ssv", {"set.ssv": values.encode()}, (("parameters", "FILE"),))


def _ssd(bindings: str = "") -> str:
    parts = "".join(
        packages.component(n, "one.fmu", "input force Real N", "output x Real m", bindings=b)
        for n, b in (("one", bindings), ("two", ""))
    )
    links = f"<ssd:Connections>{packages.connection('one/x', 'two/force')}</ssd:Connections>"
    return packages.description(f"<ssd:Elements>{parts}</ssd:Elements>{links}")


def _is_package(path: Path) -> object:
    return path.read_bytes()[:1] == b"<" if path.suffix == ".ssv" else Package(path)


# ---- meshes, line files, results, programs ----

GDF = b"hull\n1 9.81\n0 0\n1\n0 0 0\n1 0 0\n1 0 -1\n0 0 -1\n"
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 0, -1), (0, 0, -1))
PNL = """    --------------Hull Mesh File---------------

    # Number of Panels, Nodes, X-Symmetry and Y-Symmetry
         1           4           0           0

    # Start Definition of Node Coordinates     ! node_number   x   y   z
    1 0 0 0
    2 1 0 0
    3 1 0 -1
    4 0 0 -1
    # End Definition of Node Coordinates

    # Start Definition of Node Relations   ! panel_number  number_of_vertices   Vertex1_ID ...
    1 4 1 2 3 4
    # End Definition of Node Relations
"""


def _meshes() -> Iterator[Seed]:
    facets = [((0, 0, 1), *CORNERS[:3]), ((0, 0, 1), CORNERS[0], *CORNERS[2:])]
    binary = bytes(80) + struct.pack("<I", len(facets))
    binary += b"".join(struct.pack("<12fH", *(x for p in one for x in p), 0) for one in facets)
    lines = ["solid a"]
    for normal, *corners in facets:
        lines += [f"facet normal {' '.join(map(str, normal))}", "outer loop"]
        lines += [f"vertex {' '.join(map(str, corner))}" for corner in corners]
        lines += ["endloop", "endfacet"]
    ascii_stl = "\n".join([*lines, "endsolid a"]).encode()
    nemoh = "2 0\n" + "".join(f"{k} {x} {y} {z}\n" for k, (x, y, z) in enumerate(CORNERS, 1))
    nemoh += "0 0 0 0\n1 2 3 4\n0 0 0 0\n"
    files = {"hull.gdf": GDF, "hull.stl": binary, "ascii.stl": ascii_stl,
             "hull.nemoh": nemoh.encode(), "hull.pnl": PNL.encode()}  # fmt: skip
    for name, content in files.items():
        yield Seed(f"mesh {name}", {name: content}, (("mesh", "FILE"),))


def _is_mesh(path: Path) -> bool:
    content = path.read_bytes()
    if path.suffix == ".stl":
        count = int.from_bytes(content[80:84], "little")
        return content.startswith(b"solid") or len(content) == 84 + 50 * count
    lines = content.decode().splitlines()
    return len(lines) > 5 and any(word.isdecimal() for line in lines[:5] for word in line.split())


def _lines() -> Iterator[Seed]:
    content = (ROOT / "tests" / "data" / "moordyn" / "moorpy_case1.dat").read_bytes()
    yield Seed("lines", {"lines.dat": content}, (("lines", "FILE"),))


def _has_sections(path: Path) -> bool:
    return path.read_text("utf-8").count("---") > 2


SECTIONS = (
    RowSection("one", (ResultColumn("x", "m", "position"), ResultColumn("v", "m/s", "speed"))),
    RowSection("two", (ResultColumn("on", "", "switch", Recorded("Boolean", "i1")),
                    ResultColumn("text", "", "a text", Recorded("String", "str"))), CELLS),
)  # fmt: skip


def _results() -> Iterator[Seed]:
    blocks = [(np.arange(3.0)[:, None], np.ones((3, 2)), np.array([[0, 0], [1, 0], [1, 0]]))]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "r.nc")
        write_netcdf(path, SECTIONS, {"title": "a"}, 3, blocks, ("a",))
        yield Seed("results netcdf", {"r.nc": path.read_bytes()}, (("results", "FILE"),))
        rows = RowFile(Path(folder, "rows.nc"), SECTIONS, {"title": "a"}, room=512)
        rows.keep_texts(("a",))
        rows.append(0, blocks[0])
        rows.end("at the stop time", {"more": "b"})
        rows.close()
        yield Seed("results rows", {"r.nc": rows.path.read_bytes()}, (("results", "FILE"),))


def _is_results(path: Path) -> bool:
    return path.read_bytes().startswith((MAGIC, b"\x89HDF\r\n\x1a\n"))


def _programs() -> Iterator[Seed]:
    for program, entries in ((every_operation(), [(0, 0, 1)]), robertson()):
        content = {"a.m4e": encode(program, entries)}
        yield Seed(f"program {program.name}", content, (("program", "FILE"),))


def _is_program(path: Path) -> bool:
    import zlib

    data = path.read_bytes()
    return len(data) > 80 and zlib.crc32(data[16:]) == int.from_bytes(data[12:16], "little")


@cache
def families() -> dict[str, Family]:
    """All families by name; their cases are those of a whole campaign."""
    parts = (
        Family("yaml", 10_000, lambda: (*_models(), *_systems()), Document.load),
        Family("fmu", 2_000, _fmus, check_archive),
        Family("ssp", 1_000, _packages, _is_package),
        Family("mesh", 1_000, _meshes, _is_mesh),
        Family("lines", 1_000, _lines, _has_sections),
        Family("results", 1_000, _results, _is_results),
        Family("program", 1_000, _programs, _is_program),
    )
    return {family.name: family for family in parts}


def is_archive(content: bytes) -> bool:
    """True if the content can be read as a ZIP archive."""
    return zipfile.is_zipfile(io.BytesIO(content))
