"""Files of coefficients: what becomes of their numbers, what is told, and that formats agree."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from support.coefficient_files import FLAP, SPHERE, rm3_files
from support.hulls import checked_program, configured, hulls, silent

from m4e_adapters.hydrodynamics import Coefficients, coefficients_from_config
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_fmi.errors import InputError

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


def of(text: str, folder: Path) -> tuple[Coefficients, list[str]]:
    told: list[str] = []
    return coefficients_from_config(configured(text), folder=folder, progress=told.append), told


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with good files: rm3.1, .3, .hst (heave only), ball.h5, flap.nc."""
    rm3_files(tmp_path, (3, 9))
    shutil.copy(SPHERE, tmp_path / "ball.h5")
    shutil.copy(FLAP, tmp_path / "flap.nc")
    return tmp_path


def rewritten(path: Path, change: Callable[[netCDF4.Dataset], object]) -> None:
    path.chmod(0o644)
    with netCDF4.Dataset(path, "r+") as file:
        file.set_auto_mask(False)
        change(file)


def set_to(name: str, value: float, place: object = slice(None)) -> Callable:
    return lambda file: file[name].__setitem__(place, value)


@pytest.mark.parametrize(
    ("text", "change", "expected"),
    [
        (HINGED, set_to("wave_direction", np.nan), "there are no wave directions"),
        (HINGED, set_to("added_mass", np.nan), "0 frequencies above 0 have data"),
        (HINGED, set_to("forward_speed", 1.0, ...), "have a forward speed"),
        (
            HINGED,
            lambda file: file.renameVariable("added_mass", "added_weight"),
            "there is no added_mass",
        ),
        (
            HINGED,
            lambda file: file["omega"].__setitem__(20, file["omega"][21]),
            "is there twice",
        ),
        # phases of the other convention
        (
            BALL,
            lambda file: file["body1/hydro_coeffs/excitation/im"].__setitem__(
                slice(None), -file["body1/hydro_coeffs/excitation/im"][:]
            ),
            "has the opposite sign",
        ),
    ],
)
def test_wrong_datasets(
    folder: Path, text: str, change: Callable[[netCDF4.Dataset], object], expected: str
) -> None:
    rewritten(folder / ("ball.h5" if text is BALL else "flap.nc"), change)
    with pytest.raises(InputError, match=expected) as caught:
        checked_program(text, folder)
    assert caught.value.problems[0].keys == ("coefficients",)


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
    for name in ("omega", "added_mass", "excitation"):
        assert np.array_equal(getattr(other, name), getattr(good, name))


@pytest.mark.parametrize(
    ("weight_z", "key"),
    [(-0.4, ""), (-1.3, ", weight_at: [0, 0, -1.3]"), (0.0, ", weight_at: [0, 0, 0]")],
)
def test_the_weight_in_the_stiffness_of_wamit(folder: Path, weight_z: float, key: str) -> None:
    """A box of 6 by 4 by 2 m about (0, 0, 0), its .hst with or without its weight."""
    for name, modes in (("rm3.1", (1, 2)), ("rm3.3", (2,))):
        first, *rows = (folder / name).read_text("utf-8").splitlines()
        kept = [row for row in rows if all(row.split()[c] == "3" for c in modes)]
        (folder / name).write_text("\n".join([first, *kept]), "utf-8")
    own = -48.0 - 48.0 * weight_z  # V z_B - V z_G
    values = {(3, 3): 24.0, (4, 4): 24 * 16 / 12 + own, (5, 5): 24 * 36 / 12 + own}
    rows = [f"{i} {j} {values.get((i, j), 0.0):.8e}" for i in range(1, 7) for j in range(1, 7)]
    (folder / "rm3.hst").write_text("\n".join(rows), "utf-8")
    body = f"{{center_of_gravity: [0, 0, -0.4], reference_point: [0, 0, 0], volume: 48{key}}}"
    water = "dimensions: 3, water: {density: 1000}"
    made, told = of(f"{{coefficients: rm3.1, {water}, bodies: {{b: {body}}}}}", folder)
    pitch = made.hydrostatic_stiffness[4, 4] / (made.density * made.gravity)
    # I_yy + V (z_B - z_G) = 72 + 48 (-1 + 0.4)
    assert pitch == pytest.approx(72.0 - 28.8)
    assert any("its hydrostatic stiffness with the weight at (" in t for t in told)


def test_a_file_about_another_centre_of_gravity(folder: Path) -> None:
    """BEMIO's stiffness has its weight at the centre of gravity of the file."""
    text = BALL.replace("{coeff", "{dimensions: 3, coeff")
    own, _ = of(text, folder)
    (x, y, z), volume = own.centers[0], own.buoyancy[2]
    given = f"{{center_of_gravity: [{x}, {y}, {z - 0.5}]}}"
    lower, told = of(text.replace("{}", given), folder)
    # a ball turns about its middle without effort: 4, 4 is the weight's lever
    change = lower.hydrostatic_stiffness[3, 3] - own.hydrostatic_stiffness[3, 3]
    assert change == pytest.approx(0.5 * volume, rel=1e-6)
    assert any(
        line.endswith(f"with the weight at ({x:.6g}, {y:.6g}, {z:.6g}) m (file)") for line in told
    )


def test_bodies_by_name_in_another_order_and_without_each_other(folder: Path) -> None:
    named = RM3.replace("float:", "body1:").replace("spar:", "body2:")
    *head, one, two = named.splitlines()
    straight, crossed, apart = (
        of(text, folder)[0]
        for text in (named, "\n".join([*head, two, one]), f"{named}body_to_body: false\n")
    )
    assert crossed.bodies == ("body2", "body1")
    assert crossed.added_mass_inf[2, 8] == straight.added_mass_inf[8, 2] < 0
    assert not apart.added_mass_inf[2, 8]
    assert not apart.radiation_damping[:, 8, 2].any()
    assert apart.added_mass_inf[2, 2] == straight.added_mass_inf[2, 2]


def test_formats_agree_about_any_point(tmp_path: Path) -> None:
    """Capytaine's netCDF and WAMIT files about a point off the hull, and our own coefficients."""
    from capytaine import BEMSolver, FloatingBody, Mesh, export_dataset, rigid_body_dofs
    from xarray import Dataset

    text = "bodies: {box: {shape: {box: {length: 8, width: 5, draft: 2, center_x: 1}}, panels: 60, "
    own = configured(f"{{dimensions: 3, {text}center_of_gravity: [0.5, 0.2, -0.7]}}}}}}")
    (hull,) = hulls(own)
    omega, point = np.linspace(0.4, 2.0, 8), (1.5, -0.6, 0.4)
    ours = solve_hulls([hull], water=own.water, omega=omega, progress=silent)
    mesh = Mesh(hull.panels.vertices, hull.panels.faces, auto_check=False)
    lid = hull.lid and Mesh(hull.lid.vertices, hull.lid.faces, auto_check=False)
    body = FloatingBody(
        mesh=mesh, lid_mesh=lid, center_of_mass=hull.center, name="box",
        dofs=rigid_body_dofs(rotation_center=point),
    )  # fmt: skip
    tests = Dataset(coords={
        "omega": [*omega, np.inf], "wave_direction": np.linspace(0.0, 2 * np.pi, 9, endpoint=False),
        "radiating_dof": list(body.dofs), "water_depth": [np.inf], "rho": [1025.0],
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
    of_nc, _ = of("{dimensions: 3, coefficients: box.nc, bodies: {box: {}}}", tmp_path)
    of_wamit, _ = of(
        f"{{dimensions: 3, coefficients: box.1, bodies: {{box: {{{given}}}}}}}", tmp_path
    )

    def check(found: np.ndarray, expected: np.ndarray, error: float) -> None:
        assert found == pytest.approx(expected, abs=error * np.abs(expected).max())

    for found, error in ((of_nc, 1e-6), (of_wamit, 1e-5)):
        for name in ("added_mass", "radiation_damping"):
            one, other = getattr(found, name), getattr(ours, name)
            if found is of_wamit:  # Capytaine 3.0 writes the transposed matrices
                one, other = (0.5 * (x + x.swapaxes(1, 2)) for x in (one, other))
            check(one, other, error)
        check(found.hydrostatic_stiffness, about_center, error)
        check(found.buoyancy, ours.buoyancy, error)
        check(found.excitation, ours.excitation, 10 * error)
    check(of_nc.added_mass_inf, ours.added_mass_inf, 2e-6)
