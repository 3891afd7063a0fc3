"""Faults of one line, for a campaign that plants them and looks whether tests notice.

A fault is located by its text within a folder, where it stands once.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

PARTS = (
    "m4e_fmi",
    "adapters",
    "fmus",
    "tests",
    "examples",
    "docs",
    "pyproject.toml",
    "CHANGELOG.md",
)
LEFT_OUT = shutil.ignore_patterns("__pycache__", "build", "generated", "*.fmu", "benchmark")
LONGEST = 900.0
"""Seconds for the tests of one fault."""


@dataclass(frozen=True)
class Fault:
    """`planted` in place of `original`, which stands once in the files below `folder`."""

    folder: str
    original: str
    planted: str
    tests: str
    """Files or folders below tests/, between spaces."""

    def file(self, root: Path) -> Path:
        """The file with the original text; AssertionError unless it stands there once."""
        files = (root / self.folder).rglob("*.py")
        found = [f for f in files for _ in range(f.read_text("utf-8").count(self.original))]
        assert len(found) == 1, f"{self.original!r} stands {len(found)} times in {self.folder}"
        return found[0]


def copy_tree(root: Path, copy: Path) -> Path:
    """Copy what tests need of the source tree into the folder `copy`."""
    for part in PARTS:
        if (root / part).is_dir():
            shutil.copytree(root / part, copy / part, ignore=LEFT_OUT)
        else:
            shutil.copy(root / part, copy)
    return copy


def outcome(tree: Path, tests: str) -> subprocess.CompletedProcess[str]:
    """Exit code and output of pytest in a copy of the tree, up to the first failure."""
    paths = [str(tree / "tests" / name) for name in tests.split()]
    packages = os.pathsep.join(str(tree / part) for part in (".", "adapters", "fmus"))
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider", *paths],
        cwd=tree,
        env={**os.environ, "PYTHONPATH": packages},
        capture_output=True,
        text=True,
        timeout=LONGEST,
    )


LOADS = "verification/test_multibody_loads.py unit/model/test_coinciding_points.py"
LAGRANGE = "verification/test_multibody_lagrange.py verification/test_multibody_conventions.py"
FAULTS = {
    # ---- mechanics ----
    "a bushing stores twice the energy": Fault(
        "m4e_fmi/multibody", "dot(elastic, line) / 2", "dot(elastic, line)", LOADS
    ),
    "a stop stores twice the energy": Fault(
        "m4e_fmi/multibody", "back * depth / 2", "back * depth", LOADS
    ),
    "a stop pulls back": Fault(
        "m4e_fmi/multibody",
        "minimum(maximum(damping * speed, -back), back)",
        "minimum(damping * speed, back)",
        LOADS,
    ),
    "drag of a rotation drives it": Fault("m4e_fmi/multibody", "abs(parts[0])", "parts[0]", LOADS),
    "a force in body axes is in world axes": Fault(
        "m4e_fmi/multibody", 'load.axes == "body"', 'load.axes == "none"', LOADS
    ),
    "a spring's energy is that of twice its extension": Fault(
        "m4e_fmi/multibody", "force * extension / 2", "force * extension", LOADS
    ),
    "potential energy of x, not z": Fault(
        "m4e_fmi/multibody",
        "dot(scaled(mass, assembly.gravity), frame.position)",
        "dot(scaled(mass, assembly.gravity[::-1]), frame.position)",
        f"{LAGRANGE} verification/test_double_pendulum_example.py",
    ),
    "power of efforts is left out of the balance": Fault(
        "m4e_fmi/multibody",
        "plus(total, times(effort, rate))",
        "plus(total, -times(effort, rate))",
        "property/test_spatial_trees.py",
    ),
    # ---- programs and the runtime ----
    "derivative of the cosine": Fault(
        "m4e_fmi/program",
        "return -(sin(a) * da)",
        "return sin(a) * da",
        "property/test_derivatives.py",
    ),
    # ---- simulation and analysis ----
    "the stop time comes twice": Fault(
        "m4e_fmi/simulate", "- 1e-9 * interval", "+ 1e-9 * interval", "unit/simulate"
    ),
    "energy audit from the absolute potential": Fault(
        "m4e_fmi/simulate",
        "[kinetic, potential - potential[0], *works]",
        "[kinetic, potential, *works]",
        "unit/simulate",
    ),
    "direct feed-through is left out of the response": Fault(
        "m4e_fmi/analysis",
        "linear.C @ states + linear.D",
        "linear.C @ states",
        "unit/analysis verification/test_linear_analysis.py",
    ),
    "sign of the linear damping": Fault(
        "m4e_fmi/analysis",
        "Mechanical(M, C=C,",
        "Mechanical(M, C=-C,",
        "unit/analysis verification/test_linear_analysis.py",
    ),
    "rest is a hundred times as coarse": Fault(
        "m4e_fmi/analysis", "ACCURACY = 1e-12", "ACCURACY = 1e-3", "unit/analysis"
    ),
    "trapezoid of a mean becomes a plain mean": Fault(
        "m4e_fmi/report",
        "np.trapezoid(values, time) / span if span else values[0]",
        "np.mean(values)",
        "unit/report",
    ),
    # ---- coupling ----
    "the coupling of heave and pitch stiffens": Fault(
        "fmus/m4e_fmus/water",
        "turn - coupling**2 / heave",
        "turn + coupling**2 / heave",
        "unit/fmus/water/test_flotation.py unit/fmus/water/test_flotation_in_space.py",
    ),
    "mean of a Taylor series": Fault(
        "m4e_fmi/cosim",
        "self._taylor(size / 2, size**2 / 6)",
        "self._taylor(size / 2, size**2 / 2)",
        "verification/test_cosim_order.py unit/cosim/algorithms",
    ),
    "weight of a parabola": Fault(
        "m4e_fmi/cosim",
        "weight = size**2 / 6",
        "weight = size**2 / 3",
        "verification/test_cosim_order.py unit/cosim/algorithms",
    ),
    "exponent of the step control": Fault(
        "m4e_fmi/cosim",
        "error ** (-1 / self._order)",
        "error ** (-2 / self._order)",
        "verification/test_cosim_adaptive.py unit/cosim/algorithms",
    ),
    "steps beyond the largest": Fault(
        "m4e_fmi/cosim",
        "int(min(max(wanted, self._smallest), self._largest))",
        "int(max(wanted, self._smallest))",
        "unit/cosim/stepping",
    ),
    "attempts count without bound": Fault(
        "m4e_fmi/cosim/stepping",
        "OF_NOMINAL = 0.01",
        "OF_NOMINAL = 1.0",
        "unit/cosim/stepping",
    ),
    "curvature of the energy balance": Fault(
        "m4e_fmi/cosim",
        "found - sizes**3 / 12",
        "found + sizes**3 / 12",
        "verification/test_cosim_energy.py unit/cosim/time_loop",
    ),
    "followed forces bend twice as much": Fault(
        "m4e_fmi/cosim",
        "bent = sizes / 12",
        "bent = sizes / 6",
        "verification/test_cosim_energy.py unit/cosim/time_loop",
    ),
    "the mean force of a towed body is taken out": Fault(
        "m4e_fmi/cosim",
        "np.abs(sums.way) <= sums.distance / 2",
        "np.abs(sums.way) <= sums.distance",
        "verification/test_cosim_energy.py unit/cosim/time_loop",
    ),
    # ---- results and files ----
    "a lock keeps nobody out": Fault(
        "m4e_fmi/files",
        "fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)",
        "fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)",
        "unit/files",
    ),
    "a file that changes between two readings": Fault(
        "m4e_fmi/files",
        "files[name] = CHANGING",
        "files[name] = content",
        "unit/files unit/cosim/preparation",
    ),
    "new files of other machines are left over": Fault(
        "m4e_fmi/files",
        "st_mtime < time.time() - OLD",
        "st_mtime < time.time() + OLD",
        "unit/files",
    ),
    "a text that is just too long": Fault(
        "m4e_fmi/files", "len(content) > largest", "len(content) > largest + 1", "unit/files"
    ),
    "unit of a divisor": Fault(
        "m4e_fmi", "factor *= scale**direction", "factor *= scale", "unit/test_units.py"
    ),
    "a knot in the wrong unit": Fault("m4e_fmi", "1852 / 3600", "1852 / 360", "unit/test_units.py"),
    "wrong input is exit code 1": Fault(
        "m4e_fmi/cli", "EXIT_USAGE = 2", "EXIT_USAGE = 1", "unit/cli/test_quoted_texts.py"
    ),
    # ---- FMUs ----
    "derivatives refer to the variable before": Fault(
        "m4e_fmi/fmu/export",
        "str(number[v.derivative_of])",
        "str(number[of] - 1)",
        "unit/fmu/export conformance/test_fmu_kinds.py conformance/test_fmu_contents.py",
    ),
    "small dependencies are not looked at": Fault(
        "m4e_fmi/fmu/validation",
        "SIGNIFICANT = 1e-9",
        "SIGNIFICANT = 1e3",
        "conformance/test_validation.py",
    ),
    # ---- adapters and kinds ----
    "excitation lags instead of leading": Fault(
        "adapters",
        "waves.amplitude[k] * imaginary * s",
        "waves.amplitude[k] * -imaginary * s",
        "verification/test_hydrodynamics_sphere.py conformance/test_reference_series.py",
    ),
    "a line's buoyancy is left out": Fault(
        "adapters",
        "self.half_buoyancy * submerged(at, self.diameter / 2) - self.half_weight",
        "-self.half_weight",
        "unit/adapters/moordyn/test_statics.py",
    ),
    "a table begins late": Fault(
        "fmus",
        "(1.0 - reached[0]) * values[0]",
        "(1.0 - reached[0]) * values[-1]",
        "unit/fmus/test_table.py",
    ),
}
