"""Random mooring lines in a vertical plane, and their equilibrium by another formulation.

The reference has the same number of segments as the line, so that it judges where a line starts and
not how finely it is divided, which makes an error of some 1/N². It knows no nodes: the pull in the
uppermost segment, two numbers, gives that in all others, and so where the lower end is. The seabed
is rigid, MoorDyn's yields by some millimetres; all of the line is in the water.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize, root
from support.lines_in_waves import lines_of

from m4e_adapters.moordyn import MooringConfig, mooring
from m4e_fmi.files.document import Document

DENSITY, GRAVITY = 1025.0, 9.80665


@dataclass(frozen=True)
class Line:
    """From an anchor at (0, `low`) to a fairlead at (`span`, `high`) [m], above a bed at −`depth`.

    diameter [m], mass [kg/m] in air, stiffness EA [N], length [m] unstretched.
    """

    span: float
    low: float
    high: float
    depth: float
    length: float
    diameter: float
    mass: float
    stiffness: float
    segments: int

    @property
    def weight(self) -> float:
        """In water [N/m]."""
        return (self.mass - DENSITY * math.pi * self.diameter**2 / 4) * GRAVITY

    @property
    def text(self) -> str:
        """The mooring section of a system file."""
        return (
            f"water: {{density: {DENSITY}, depth: {self.depth!r}, gravity: {GRAVITY}}}\n"
            f"line_types:\n  c: {{diameter: {self.diameter!r}, mass_per_length: {self.mass!r}, "
            f"axial_stiffness: {self.stiffness!r}, axial_damping_ratio: 1, drag_coefficient: 1.2, "
            "added_mass_coefficient: 1}\n"
            f"anchors: {{a: [0, {self.low!r}]}}\nfairleads: {{f: [{self.span!r}, {self.high!r}]}}\n"
            f"lines:\n  l: {{type: c, from: a, to: f, unstretched_length: {self.length!r}, "
            f"segments: {self.segments}}}\n"
        )


def random_line(rng: np.random.Generator) -> Line:
    """Slack to taut, on the seabed or above it, nearly neutral to heavy, 5 to 20 segments."""
    low = -(10 ** rng.uniform(1.3, 2.9))
    high = -rng.uniform(0.5, 5.0)
    rise = high - low
    span = rise * rng.uniform(0.2, 4.0)
    chord = math.hypot(span, rise)
    longest = 0.9 * (span + rise)  # a line of 1.0 hangs straight down and pulls no one sideways
    slack = rng.choice([rng.uniform(0.996, 1.002), rng.uniform(1.002, 1.1), rng.uniform(1.1, 1.6)])
    length = max(0.996 * chord, min(slack * chord, longest))
    # anchored on the seabed, or so far above that no line reaches it
    depth = -low if rng.random() < 0.7 else -low + length
    diameter = 10 ** rng.uniform(-1.5, -0.6)
    area = math.pi * diameter**2 / 4
    mass = DENSITY * area * (1.05 + 10 ** rng.uniform(-1.2, 0.8))
    return Line(
        span=float(span),
        low=float(low),
        high=float(high),
        depth=float(depth),
        length=float(length),
        diameter=float(diameter),
        mass=float(mass),
        stiffness=float(10 ** rng.uniform(6.5, 9.3)),
        segments=int(rng.choice([5, 8, 12, 20])),
    )


def tension(line: Line) -> float:
    """Force [N] of the line on its fairlead, at rest, with half a segment's weight.

    Of the pull (H, V) [N] in the uppermost segment the complementary energy is convex: its gradient
    is how far the anchor's end is from the anchor.
    """
    piece = line.length / line.segments
    above = line.weight * piece * np.arange(line.segments)[::-1]  # on the segment, from A to B
    ends = np.array([line.span, line.high - line.low])
    scale = line.weight * line.length
    lies = line.low <= -line.depth

    def pulls(x: np.ndarray) -> np.ndarray:
        up = x[1] * scale - above
        return np.array([np.full_like(up, x[0] * scale), np.maximum(up, 0) if lies else up])

    def way(x: np.ndarray) -> np.ndarray:
        pull = pulls(x)
        return piece * pull * (1 / np.maximum(np.hypot(*pull), 1e-9 * scale) + 1 / line.stiffness)

    def energy(x: np.ndarray) -> float:
        pull = np.hypot(*pulls(x))
        total = piece * np.sum(pull + pull**2 / (2 * line.stiffness)) / scale
        return float(total - x @ ends) / line.length

    def gradient(x: np.ndarray) -> np.ndarray:
        return (way(x).sum(axis=1) - ends) / line.length

    start = np.array([0.5, 1.0])
    rough = minimize(energy, start, jac=gradient, method="BFGS", options={"gtol": 1e-6})
    fine = root(gradient, rough.x, tol=1e-12)
    x = fine.x if np.abs(gradient(fine.x)).max() < np.abs(gradient(rough.x)).max() else rough.x
    assert np.abs(gradient(x)).max() < 1e-6, (line, gradient(x))
    heights = line.low + np.cumsum(way(x)[1])
    assert heights.min() > -line.depth - 1e-6 * line.length, (line, heights.min())
    return math.hypot(x[0] * scale, x[1] * scale + line.weight * piece / 2)


def start_error(line: Line) -> tuple[float, bool]:
    """Tension at the start over that of the equilibrium, less 1, and whether a warning tells."""
    made = mooring(Document.parse(line.text).validate(MooringConfig))
    system = lines_of(made)
    system.start([(line.span, line.high)], [(0.0, 0.0)])
    system.close()
    warned = any("does not start at rest" in text for text in system.warnings)
    return system.tensions()[0][0] / tension(line) - 1, warned
