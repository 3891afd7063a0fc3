"""Files of coefficients: what is refused, what is said, and that formats agree."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from support.coefficient_files import FLAP, SPHERE, changed, rm3_files

from m4e_adapters.hydrodynamics import (
    Coefficients,
    HydrodynamicsConfig,
    coefficients_from_config,
)
from m4e_adapters.hydrodynamics.build import check_config
from m4e_adapters.hydrodynamics.coefficient_files.infinite_frequency import ogilvie
from m4e_adapters.hydrodynamics.coefficient_files.reading import read_coefficient_file
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document

RM3 = """\
coefficients: rm3.1
dimensions: 3
water: {density: 1000}
bodies:
  float: {center_of_gravity: [0, 0, -0.72], volume: 725.834}
  spar: {center_of_gravity: [0, 0, -21.29], volume: 886.691}
"""
BALL = "{coefficients: ball.h5, bodies: {ball: {}}}"
HINGED = "{coefficients: flap.nc, bodies: {oswec_flap: {center_of_gravity: [0, -3.9]}}}"
HEAVE = (3, 9)
Lines = list[str]


def of(text: str, folder: Path) -> tuple[Coefficients, list[str]]:
    config = Document.parse(text).validate(HydrodynamicsConfig)
    told: list[str] = []
    return coefficients_from_config(config, folder=folder, progress=told.append), told


def refusal(text: str, folder: Path) -> InputError:
    with pytest.raises(InputError) as error:
        check_config(Document.parse(text).validate(HydrodynamicsConfig), folder=folder)
    return error.value


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with good files: rm3.1, .3, .hst (heave only), ball.h5, flap.nc."""
    rm3_files(tmp_path, HEAVE)
    shutil.copy(SPHERE, tmp_path / "ball.h5")
    shutil.copy(FLAP, tmp_path / "flap.nc")
    return tmp_path


def rewritten(path: Path, change: Callable[[netCDF4.Dataset], object]) -> None:
    path.chmod(0o644)
    with netCDF4.Dataset(path, "r+") as file:
        file.set_auto_mask(False)
        change(file)


WRONG_LINES: dict[str, tuple[str, Callable[[Lines], Lines], str]] = {
    "a row cut off": (
        "rm3.1", lambda rows: [*rows[:-1], rows[-1][:20]], r"rm3\.1:\d+:\d+: a row has 4 or 5"),
    "rows cut off": ("rm3.1", lambda rows: rows[:-2], r"rm3\.1:\d+:\d+: PER = .* has 2 rows, "),
    "a word": (
        "rm3.3", lambda rows: [*rows[:9], rows[9].replace("E", "x"), *rows[10:]],
        r"rm3\.3:10:\d+: '.*' is not a number"),
    "no numbers": ("rm3.hst", lambda rows: rows[:1], r"rm3\.hst:1: there are no numbers"),
    "hydrostatics cut off": ("rm3.hst", lambda rows: rows[:40], r"rm3\.hst:40:\d+: the file ends"),
    "a mode that is none": (
        "rm3.1", lambda rows: [*rows[:5], "  1.0  0  3  1.0  1.0", *rows[5:]], r"mode 0 is not"),
    "no damping": (
        "rm3.1", lambda rows: [" ".join(r.split()[:4]) for r in rows], r"there is no damping at"),
    "a row twice": ("rm3.1", lambda rows: [*rows[:20], *rows[19:]], r"a second row of the modes"),
    "bodies of two numbers": (
        "rm3.3", lambda rows: [r for r in rows if " 9  " not in r], r"of different numbers of bod"),
    "too few frequencies": (
        "rm3.1", lambda rows: rows[:29], r"\d frequencies above 0 have data, .* needs 8"),
    "no directions": ("rm3.3", lambda rows: rows[:1], r"rm3\.3:1: there are no numbers"),
    "a modulus that is none": (
        "rm3.3", lambda rows: [*rows[:9], " ".join([*rows[9].split()[:3], "9e9",
        *rows[9].split()[4:]]), *rows[10:]], r"rm3\.3:10:\d+: MOD is 9e\+09, that of RE and IM"),
    "a negative A∞": (
        "rm3.1", lambda rows: [re.sub(r"^( *0\.0\S* .* )(\S+)$", r"\1 -2.0E+3", r) for r in rows],
        r"added mass at infinite frequency of .* is negative"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG_LINES)
def test_wrong_lines_of_wamit(folder: Path, case: str) -> None:
    name, change, expected = WRONG_LINES[case]
    changed(folder / name, change)
    assert re.search(expected, str(refusal(RM3, folder)))


def test_all_problems_of_all_files_at_once(folder: Path) -> None:
    changed(folder / "rm3.1", lambda rows: [*rows[:5], "1.0 x 3 1.0 1.0", "7", *rows[5:]])
    (folder / "rm3.3").unlink()
    text = str(refusal(RM3, folder))
    assert "rm3.1:6:5: 'x' is not a number" in text
    assert "rm3.1:7:1: a row has 4 or 5 numbers, this one 1" in text
    assert "no such file" in text
    assert "3 problems" in text


def test_letters_of_another_case(folder: Path) -> None:
    (folder / "rm3.hst").rename(folder / "RM3.HST")
    assert "rename RM3.HST to rm3.hst" in str(refusal(RM3, folder))


def _without_directions(file: netCDF4.Dataset) -> None:
    file["wave_direction"][:] = np.nan


def _nothing_but_nan(file: netCDF4.Dataset) -> None:
    file["added_mass"][:] = np.nan


def _words(file: netCDF4.Dataset) -> None:
    file.renameVariable("added_mass", "added_weight")


def _twice(file: netCDF4.Dataset) -> None:
    file["omega"][20] = file["omega"][21]


def _fast(file: netCDF4.Dataset) -> None:
    file["forward_speed"][...] = 1.0


WRONG_DATASETS = {
    "headings missing": (_without_directions, "there are no wave directions"),
    "only NaN": (_nothing_but_nan, "0 frequencies above 0 have data"),
    "no added mass": (_words, "there is no added_mass"),
    "a frequency twice": (_twice, "is there twice"),
    "a forward speed": (_fast, "have a forward speed"),
}


@pytest.mark.parametrize("case", WRONG_DATASETS)
def test_wrong_datasets_of_capytaine(folder: Path, case: str) -> None:
    change, expected = WRONG_DATASETS[case]
    rewritten(folder / "flap.nc", change)
    error = refusal(HINGED, folder)
    assert expected in str(error)
    assert error.problems[0].keys == ("coefficients",)


@pytest.mark.parametrize("name", ["ball.h5", "flap.nc"])
def test_cut_off(folder: Path, name: str) -> None:
    path = folder / name
    path.chmod(0o644)
    path.write_bytes(path.read_bytes()[:20_000])
    text = BALL if name == "ball.h5" else HINGED
    assert re.search(f"{name}.* damaged", str(refusal(text, folder)))


@pytest.mark.parametrize(
    ("text", "keys", "expected"),
    [
        (BALL.replace("ball.h5", "ball.csv"), ("coefficients",), "suffix '.csv'"),
        (BALL.replace("ball.h5", "bal.h5"), ("coefficients",), "did you mean 'ball.h5'?"),
        (BALL[:-2] + ", other: {}}}", ("bodies",), "1 body ('sphere'), here are 2"),
        (BALL[:-1] + ", water: {depth: 30}}", ("water", "depth"), "30 m here, the file is for 200"),
        (BALL[:-1] + ", water: {depth: deep}}", ("water", "depth"), "deep m here"),
        (
            BALL[:-1] + ", water: {density: 1025}}", ("water", "density"),
            "density is 1025 kg/m3 here, the file is for 1000 kg/m3",
        ),
        (BALL[:-1] + ", water: {gravity: 9.7}}", ("water", "gravity"), "9.7 m/s2 here"),
        (BALL.replace("{}}", "{volume: 1}}"), ("bodies", "ball", "volume"), "is 261.724 m3"),
        (
            BALL.replace("{}}", "{reference_point: [0, 1]}}"),
            ("bodies", "ball", "reference_point"), "are about (0, 0, -2) m",
        ),
        (RM3.replace(", volume: 725.834", ""), ("bodies", "float"), "not have the displaced"),
        (RM3.replace("center_of_gravity: [0, 0, -0.72], ", ""), ("bodies", "float"), "no centre"),
        (
            HINGED[:-1] + ", waves: {spectrum: regular, height: 1, period: 8, direction: 180}}",
            ("waves", "direction"), "0, 10, 20, 30, 40, 50, 60, 70, 80, 90 deg",
        ),
        (
            HINGED[:-1] + ", waves: {spectrum: regular, height: 1, period: 0.2}}",
            ("waves",), "the coefficients end at 20 rad/s",
        ),
    ],
)  # fmt: skip
def test_files_that_do_not_go_with_the_system(
    folder: Path, text: str, keys: tuple[str, ...], expected: str
) -> None:
    error = refusal(text, folder)
    assert expected in str(error)
    assert error.problems[0].keys == keys


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (BALL[:-1] + ", frequencies: {count: 20}}", "'frequencies' has no effect"),
        (BALL.replace("{}}", "{shape: {sphere: {radius: 5}}}}"), "'shape' has no effect with coe"),
        ("bodies: {ball: {center_of_gravity: [0, 0]}}", "missing key 'shape'"),
        (
            "bodies: {ball: {shape: {sphere: {radius: 5}}, center_of_gravity: [0, 0], volume: 1}}",
            "'volume' has no effect on a shape",
        ),
    ],
)
def test_keys_that_do_not_go_together(text: str, expected: str) -> None:
    with pytest.raises(InputError, match=re.escape(expected)):
        Document.parse(text).validate(HydrodynamicsConfig)


def test_phases_of_the_other_convention(folder: Path) -> None:
    rewritten(
        folder / "ball.h5",
        lambda file: file["body1/hydro_coeffs/excitation/im"].__setitem__(
            slice(None), -file["body1/hydro_coeffs/excitation/im"][:]
        ),
    )
    assert "has the opposite sign" in str(refusal(BALL, folder))


def test_frequencies_are_sorted_and_nan_left_out(folder: Path) -> None:
    good, told = of(HINGED, folder)
    assert any("without complete data: 0.04 rad/s" in line for line in told)

    def shuffled(file: netCDF4.Dataset) -> None:
        order = np.random.Generator(np.random.PCG64(1)).permutation(len(file["omega"][:]))
        for name in ("omega", "added_mass", "radiation_damping"):
            file[name][:] = file[name][:][order]
        file["excitation_force"][:] = file["excitation_force"][:][:, order]

    rewritten(folder / "flap.nc", shuffled)
    other, told = of(HINGED, folder)
    assert any("have been sorted" in line for line in told)
    assert other.omega.tolist() == good.omega.tolist()
    assert np.array_equal(other.added_mass, good.added_mass)
    assert np.array_equal(other.excitation, good.excitation)


BOX = (6.0, 4.0, 2.0)  # length, width, draft


def _box_hst(folder: Path, weight_z: float | None) -> None:
    """The .hst of a box about (0, 0, 0) with its weight at a height, or without weight."""
    length, width, draft = BOX
    area, volume = length * width, length * width * draft
    own = -0.5 * draft * volume - volume * (weight_z or 0.0)
    values = {(3, 3): area, (4, 4): area * width**2 / 12 + own, (5, 5): area * length**2 / 12 + own}
    rows = [f"{i} {j} {values.get((i, j), 0.0):.8e}" for i in range(1, 7) for j in range(1, 7)]
    (folder / "rm3.hst").write_text("\n".join(rows), "utf-8")


@pytest.mark.parametrize(
    ("weight_z", "key"),
    [
        (-0.4, ""),
        (-1.3, ", weight_at: [0, 0, -1.3]"),
        (None, ", weight_at: [0, 0, 0]"),
    ],
)
def test_the_weight_in_the_stiffness_of_wamit(
    folder: Path, weight_z: float | None, key: str
) -> None:
    for name, modes in (("rm3.1", (1, 2)), ("rm3.3", (2,))):
        changed(
            folder / name,
            lambda rows, modes=modes: [
                row
                for k, row in enumerate(rows)
                if not k or all(row.split()[c] == "3" for c in modes)
            ],
        )
    _box_hst(folder, weight_z)
    body = f"{{center_of_gravity: [0, 0, -0.4], reference_point: [0, 0, 0], volume: 48{key}}}"
    text = (
        f"{{coefficients: rm3.1, dimensions: 3, water: {{density: 1000}}, bodies: {{box: {body}}}}}"
    )
    made, told = of(text, folder)
    pitch = made.hydrostatic_stiffness[4, 4] / (made.density * made.gravity)
    # I_yy + V (z_B - z_G) = 72 + 48 (-1 + 0.4)
    assert pitch == pytest.approx(72.0 - 28.8)
    assert any("stiffness of 'body1' is taken as that with the weight at" in t for t in told)


def test_a_file_about_another_centre_of_gravity(folder: Path) -> None:
    """BEMIO's stiffness has its weight at the centre of gravity of the file."""
    own, _ = of(BALL.replace("{coeff", "{dimensions: 3, coeff"), folder)
    (x, y, z), volume = own.centers[0], own.buoyancy[2]
    given = f"{{center_of_gravity: [{x}, {y}, {z - 0.5}]}}"
    lower, told = of(BALL.replace("{coeff", "{dimensions: 3, coeff").replace("{}", given), folder)
    # a ball turns about its middle without effort: 4, 4 is the weight's lever
    change = lower.hydrostatic_stiffness[3, 3] - own.hydrostatic_stiffness[3, 3]
    assert change == pytest.approx(0.5 * volume, rel=1e-6)
    assert any("the file's centre of gravity, and moved" in line for line in told)


def _first_column(rows: Lines) -> Lines:
    """Rows with ω in place of the period."""
    words = [row.split() for row in rows]
    return [
        " ".join([f"{2 * np.pi / float(w[0]):.6e}", *w[1:]]) if k and float(w[0]) > 0 else row
        for k, (w, row) in enumerate(zip(words, rows, strict=True))
    ]


def test_frequencies_in_place_of_periods(folder: Path) -> None:
    for name in ("rm3.1", "rm3.3"):
        changed(folder / name, _first_column)
    error = refusal(RM3, folder)
    assert re.search(r"rm3\.1: the first column is no period", str(error))
    assert "IPEROUT" in error.problems[0].remedy


def test_no_stiffness_in_heave(folder: Path) -> None:
    changed(
        folder / "rm3.hst",
        lambda rows: [
            " ".join([*r.split()[:2], "0.0"]) if r.split()[:2] in (["3", "3"], ["9", "9"]) else r
            for r in rows
        ],
    )
    _, told = of(RM3, folder)
    assert any(re.search(r"warning: .*float: the heave .* as of a body in the", t) for t in told)


def test_sources_are_told(folder: Path) -> None:
    _, told = of(RM3, folder)
    text = "\n".join(told)
    assert "body 'float' is 'body1' of the file, number 1" in text
    assert "(0, 0, -0.72) m (system file)" in text
    assert "no density, depth, gravity: density 1000 kg/m3 of the system file, deep water" in text
    assert "phases of WAMIT are e^{+iωt}, turned to e^{−iωt}" in text
    assert "A∞ is that of the file" in text


def test_bodies_by_name_in_another_order(folder: Path) -> None:
    first, *rest = RM3.splitlines()
    by_name = "\n".join([first, *rest]).replace("float:", "body1:").replace("spar:", "body2:")
    *head, one, two = by_name.splitlines()
    turned = "\n".join([*head, two, one])
    straight, crossed = of(by_name, folder)[0], of(turned, folder)[0]
    assert crossed.bodies == ("body2", "body1")
    assert crossed.added_mass_inf[2, 8] == straight.added_mass_inf[8, 2] != 0


def test_body_to_body_terms_can_be_left_out(folder: Path) -> None:
    both, apart = of(RM3, folder)[0], of(f"{RM3}body_to_body: false\n", folder)[0]
    assert both.added_mass_inf[2, 8] < 0
    assert not apart.added_mass_inf[2, 8]
    assert not apart.radiation_damping[:, 8, 2].any()
    assert apart.added_mass_inf[2, 2] == both.added_mass_inf[2, 2]


def test_single_directions_in_space(folder: Path) -> None:
    """The flap's data are for ten directions: these can be used, and stay."""
    text = HINGED.replace("[0, -3.9]", "[0, 0, -3.9]").replace("{coeff", "{dimensions: 3, coeff")
    waves = "{spectrum: regular, height: 1, period: 8, direction: 40}"
    found, _ = of(f"{text[:-1]}, heading: 10, waves: {waves}}}", folder)
    assert found.of_single_directions
    assert found.towards(30.0).wave_direction == 30.0
    program = check_config(
        Document.parse(f"{text[:-1]}, heading: 10, waves: {waves}}}").validate(HydrodynamicsConfig),
        folder=folder,
    )
    limits = {v.name: (v.minimum, v.maximum, v.start) for v in program.parameters}
    for name, angle in (("wave.direction", 40.0), ("heading", 10.0)):
        assert limits[name] == pytest.approx((np.radians(angle),) * 3)
    with pytest.raises(InputError, match=r"at 0, 10, 20, .* not at 45 deg"):
        found.towards(45.0)


def test_added_mass_at_infinity_by_causality() -> None:
    """Of a memory K(s) = s/((s + a)² + b²), and beyond the last frequency of the data."""
    omega = np.linspace(0.05, 12.0, 240)
    s, infinite = 1j * omega, 5.0
    transfer = 3.0 * s / ((s + 0.6) ** 2 + 1.1**2)
    mass, damping = infinite + transfer.imag / omega, transfer.real
    found, spread = ogilvie(omega, mass[:, None], damping[:, None])
    assert found[0] == pytest.approx(infinite, rel=5e-3)
    assert spread[0] < 0.02
    without_tail = omega < 3.0
    short, wider = ogilvie(omega[without_tail], mass[without_tail], damping[without_tail])
    assert short == pytest.approx(infinite, rel=0.1)
    assert wider > spread


def test_a_file_of_the_given_folder_only(folder: Path) -> None:
    assert read_coefficient_file(folder / "ball.h5").bodies[0].volume == pytest.approx(261.724)


def test_formats_agree_about_any_point(tmp_path: Path) -> None:
    """Capytaine's netCDF and WAMIT files about a point off the hull, and our own coefficients."""
    from capytaine import BEMSolver, FloatingBody, Mesh, export_dataset, rigid_body_dofs
    from xarray import Dataset

    from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
    from m4e_adapters.hydrodynamics.geometry.mesh import make_hulls

    text = "bodies: {box: {shape: {box: {length: 8, width: 5, draft: 2, center_x: 1}}, panels: 60, "
    text += "center_of_gravity: [0.5, 0.2, -0.7]}}"
    own = Document.parse(f"{{dimensions: 3, {text}}}").validate(HydrodynamicsConfig)
    (hull,) = make_hulls(own, tmp_path, progress=lambda _: None)
    omega, point = np.linspace(0.4, 2.0, 8), (1.5, -0.6, 0.4)
    ours = solve_hulls([hull], water=own.water, omega=omega, progress=lambda _: None)
    mesh = Mesh(hull.panels.vertices, hull.panels.faces, auto_check=False)
    lid = hull.lid and Mesh(hull.lid.vertices, hull.lid.faces, auto_check=False)
    body = FloatingBody(
        mesh=mesh, lid_mesh=lid, center_of_mass=hull.center, name="box",
        dofs=rigid_body_dofs(rotation_center=point),
    )  # fmt: skip
    beta = np.linspace(0.0, 2 * np.pi, 9, endpoint=False)
    tests = Dataset(coords={
        "omega": [*omega, np.inf], "wave_direction": beta, "radiating_dof": list(body.dofs),
        "water_depth": [np.inf], "rho": [1025.0],
    })  # fmt: skip
    dataset = BEMSolver(method="direct").fill_dataset(tests, body)
    export_dataset(tmp_path / "box.nc", dataset)
    export_dataset(str(tmp_path / "box"), dataset.sel(omega=omega), format="wamit")
    # of Capytaine about the centre of gravity: its integrals over coarse panels are not exact
    at_center = FloatingBody(
        mesh=mesh, center_of_mass=hull.center, dofs=rigid_body_dofs(rotation_center=hull.center)
    )
    about_center = at_center.compute_hydrostatic_stiffness(rho=1025.0, g=9.81).values
    given = f"center_of_gravity: [0.5, 0.2, -0.7], reference_point: {list(point)}, volume: 80"
    of_nc, told = of("{dimensions: 3, coefficients: box.nc, bodies: {box: {}}}", tmp_path)
    of_wamit, _ = of(
        f"{{dimensions: 3, coefficients: box.1, bodies: {{box: {{{given}}}}}}}", tmp_path
    )
    assert any("about (1.5, -0.6, 0.4) m (file) moved to the centre" in line for line in told)
    assert any("9 wave directions go all around" in line for line in told)
    size = np.abs(ours.added_mass).max(axis=0)
    for found, error in ((of_nc, 1e-6), (of_wamit, 1e-5)):
        for name in ("added_mass", "radiation_damping"):
            one, other = getattr(found, name), getattr(ours, name)
            if found is of_wamit:  # Capytaine 3.0 writes the transposed matrices
                one, other = (0.5 * (x + x.swapaxes(1, 2)) for x in (one, other))
            assert one == pytest.approx(other, abs=error * np.abs(other).max())
        assert found.hydrostatic_stiffness == pytest.approx(
            about_center, abs=error * about_center.max()
        )
        assert found.buoyancy == pytest.approx(ours.buoyancy, abs=error * ours.buoyancy.max())
        assert found.excitation == pytest.approx(
            ours.excitation, abs=10 * error * np.abs(ours.excitation).max()
        )
    assert of_nc.added_mass_inf == pytest.approx(ours.added_mass_inf, abs=1e-6 * size.max())
