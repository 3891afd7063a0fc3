"""Mean work of the radiation of two coupled bodies in regular waves, and ½ v*ᵀ B(ω) v of the BEM.

Two floating boxes on linear springs and dampers, in oblique waves in space, and in the plane. The
whole system is integrated as one program until its motion is periodic; B is computed at the wave's
own frequency, which is none of those that the memory was fitted to.
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
import yaml

from m4e_adapters.hydrodynamics.build import make_hulls
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_fmi.cosim import load_system, system_program
from m4e_fmi.program import Program
from m4e_fmi.simulate import simulate

PERIODS = {"plane": (3.7, 5.9), "space": (4.6, 7.7)}  # s
WHOLE, SHOWN, PER_PERIOD = 60, 2, 128  # periods, those compared, samples in each
BODIES = {"a": (0.0, 24.0), "b": (22.0, 10.0)}  # centre and length [m]
SPACE = {
    "velocities": ("vx", "vy", "vz", "omega_x", "omega", "omega_z"),
    "forces": ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z"),
}
PLANE = {"velocities": ("vx", "vz", "omega"), "forces": ("force_x", "force_z", "moment_y")}


def _model(dimensions: int) -> str:
    """Each body on bushings at its corners, which hold all of its motions."""
    inertia = "[4e6, 2e7, 2e7]" if dimensions == 3 else "1e7"
    lines = [f"name: two\ndimensions: {dimensions}\ngravity: 9.81\nbodies:"]
    lines += [f"  {n}: {{mass: neutral, inertia: {inertia}, added_mass: true}}" for n in BODIES]
    lines += ["joints:"]
    for name, (x, _) in BODIES.items():
        lines.append(f"  s{name}: {{type: floating, child: {name}, initial: {{x: {x}, z: -0.5}}}}")
    corners = [
        (f"{name}_{k}", name, x, along * length / 2, f"{4 * aside}, " if dimensions == 3 else "")
        for name, (x, length) in BODIES.items()
        for k, (along, aside) in enumerate(product((-1, 1), (-1, 1)[: dimensions - 1]))
    ]
    lines += ["points:"]
    for corner, name, x, along, aside in corners:
        lines.append(f"  {corner}: {{body: {name}, at: [{along}, {aside}0]}}")
        lines.append(f"  {corner}_pile: {{body: ground, at: [{x + along}, {aside}-0.5]}}")
    lines += ["loads:"]
    for corner, *_ in corners:
        held = f"points: [{corner}, {corner}_pile], stiffness: 5e4, damping: 6e4"
        lines.append(f"  {corner}: {{type: bushing, {held}}}")
    return "\n".join(lines)


def _water(dimensions: int) -> str:
    aside = "0, " if dimensions == 3 else ""
    bodies = "".join(
        f"\n      {name}: {{center_of_gravity: [{x}, {aside}-0.5], panels: 64, shape: "
        f"{{box: {{length: {length}, width: 8, draft: 2, center_x: {x}}}}}}}"
        for name, (x, length) in BODIES.items()
    )
    direction = 35 if dimensions == 3 else 0
    return f"""
    dimensions: {dimensions}
    water: {{density: 1025, depth: deep, gravity: 9.81}}
    bodies: {bodies}
    frequencies: {{maximum: 2.4, count: 20}}
    waves: {{spectrum: regular, height: 0.02, period: 6, direction: {direction}}}"""


@pytest.fixture(scope="module")
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Case:
    return Case({"plane": 2, "space": 3}[request.param], tmp_path_factory.mktemp("two"))


class Case:
    """The system in some dimensions, as a program and as its hydrodynamics' keys."""

    def __init__(self, dimensions: int, folder: Path) -> None:
        (folder / "two.model.yaml").write_text(_model(dimensions), "utf-8")
        (folder / "system.yaml").write_text(
            "name: two\ncomponents:\n  bodies: {model: two.model.yaml}\n  water:\n"
            f"    kind: hydrodynamics{_water(dimensions)}\n"
            "connections: [bodies.body.a <-> water.a, bodies.body.b <-> water.b, "
            "water.added_mass -> bodies.added_mass]\n"
            "simulation: {stop_time: 10, step_size: 0.1}\n",
            "utf-8",
        )
        self.program: Program = system_program(load_system(folder / "system.yaml"))
        self.folder = folder
        self.config = HydrodynamicsConfig.model_validate(yaml.safe_load(_water(dimensions)))
        self.names = PLANE if dimensions == 2 else SPACE

    def damping(self, omega: float) -> np.ndarray:
        """B (n, n) at `omega` [rad/s]."""
        hulls = make_hulls(self.config, self.folder, progress=lambda _: None)
        found = solve_hulls(
            hulls, water=self.config.water, omega=np.array([omega]), progress=lambda _: None
        )
        return found.radiation_damping[0]

    def last_periods(self, period: float) -> tuple[np.ndarray, np.ndarray]:
        """Velocities and radiation forces (n, nt) of the last periods, one in each motion."""
        run = simulate(
            self.program,
            stop_time=WHOLE * period,
            output_interval=period / PER_PERIOD,
            tolerance=1e-9,
            start_values={"water.wave.period": period},
        )
        pairs = list(zip(self.names["velocities"], self.names["forces"], strict=True))
        names = [(b, *pair) for b in BODIES for pair in pairs]
        speeds = [run[f"bodies.body.{b}.{v}"] for b, v, _ in names]
        forces = [run[f"water.{b}.radiation_{f}"] for b, _, f in names]
        shown = slice(-SHOWN * PER_PERIOD, None)
        return np.array(speeds)[:, shown], np.array(forces)[:, shown]


@pytest.mark.verifies(
    "mean work of radiation of two bodies in regular waves, plane and space",
    analytic="1/2 v*ᵀ B(ω) v of the BEM",
    tolerance="0.005",
)
@pytest.mark.parametrize(
    ("case", "period"),
    [(name, period) for name, periods in PERIODS.items() for period in periods],
    indirect=["case"],
)
def test_mean_work(case: Case, period: float) -> None:
    omega = 2 * np.pi / period
    speeds, forces = case.last_periods(period)
    half = speeds.shape[1] // 2
    steady = np.abs(speeds[:, :half] - speeds[:, half:]).max(axis=1)
    assert steady.max() < 1e-6
    turn = np.exp(1j * omega * period / PER_PERIOD * np.arange(speeds.shape[1]))
    v = 2.0 * (speeds * turn).mean(axis=1)
    expected = 0.5 * float((v.conj() @ case.damping(omega) @ v).real)
    found = -float((forces * speeds).sum(axis=0).mean())
    print(f"{period} s: {found / expected - 1:.1e}, motions {np.abs(v)}")
    assert found == pytest.approx(expected, rel=0.005)
