"""What is measured: planar systems in neutral form, which every engine builds its own model from.

SI units. World frame: X right, Z up; an angle is about +Y and turns +Z towards +X. Coordinates are
absolute angles of revolute links and displacements of prismatic ones. Vectors are in the frame of
the link, parallel to the world's where all coordinates are zero.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

GRAVITY = 9.81
GROUND = -1

Vector = tuple[float, float]


@dataclass(frozen=True)
class Link:
    """A body and the joint that holds it: `parent` is the index of an earlier link, or GROUND.

    `parent_to_joint` leads from the parent's centre of gravity to the joint, `joint_to_child` from
    there to this one's; a prismatic joint slides along the unit vector `direction`.
    """

    parent: int
    revolute: bool
    parent_to_joint: Vector
    joint_to_child: Vector
    direction: Vector
    mass: float
    inertia: float


@dataclass(frozen=True)
class Spring:
    """Spring and damper between a point of link `first` and one of `second`, from their CGs.

    A force of stiffness · (distance − length) + damping · (its rate) pulls the points together.
    """

    first: int
    first_point: Vector
    second: int
    second_point: Vector
    stiffness: float
    length: float
    damping: float


@dataclass(frozen=True)
class Torsion:
    """Spring and damper at the revolute joint of `link`: resting where θ_link − θ_parent = angle.

    Here the parent's angle is that of the link that holds this one; 0 for the ground.
    """

    link: int
    stiffness: float
    angle: float
    damping: float


@dataclass(frozen=True)
class System:
    """Links (parents first, by distance from the ground), loads, and a state to start from."""

    name: str
    links: tuple[Link, ...]
    springs: tuple[Spring, ...]
    torsions: tuple[Torsion, ...]
    q: tuple[float, ...]
    u: tuple[float, ...]

    @property
    def size(self) -> int:
        """Number of degrees of freedom."""
        return len(self.links)

    def angle_index(self, link: int) -> int:
        """The link whose coordinate is the angle of `link`; GROUND if it never turns."""
        while link != GROUND and not self.links[link].revolute:
            link = self.links[link].parent
        return link


def pendulum(n: int) -> System:
    """n rods of 2 m and 10 kg, horizontal, at rest (Sabet and Diaz-Flores Caminero, table 5)."""
    length, mass = 2.0, 10.0
    half = (0.0, -length / 2)
    links = tuple(
        Link(
            parent=k - 1,
            revolute=True,
            parent_to_joint=half if k else (0.0, 0.0),
            joint_to_child=half,
            direction=(0.0, 0.0),
            mass=mass,
            inertia=mass * length**2 / 12,
        )
        for k in range(n)
    )
    return System(f"pendulum_{n}", links, (), (), (-math.pi / 2,) * n, (0.0,) * n)


def tree(n: int = 30, *, seed: int = 2024) -> System:
    """A random tree of n bodies, one joint in five prismatic, half of the bodies on springs."""
    rng = random.Random(seed)

    def point() -> Vector:
        return rng.uniform(-1, 1), rng.uniform(-1, 1)

    parents = _parents_by_depth(n, rng)
    links = []
    for parent in parents:
        angle = rng.uniform(-math.pi, math.pi)
        links.append(
            Link(
                parent=parent,
                revolute=parent == GROUND or rng.random() > 0.2,
                parent_to_joint=point(),
                joint_to_child=point(),
                direction=(math.cos(angle), math.sin(angle)),
                mass=rng.uniform(1, 10),
                inertia=rng.uniform(0.5, 5),
            )
        )
    springs = tuple(
        Spring(k, point(), rng.choice((GROUND, rng.randrange(k))), point(), 200.0, 1.0, 5.0)
        for k in range(1, n, 2)
    )
    torsions = tuple(
        Torsion(k, 50.0, rng.uniform(-1, 1), 2.0) for k in range(0, n, 3) if links[k].revolute
    )
    q, u = random_state(n, seed=seed)
    return System(f"tree_{n}", tuple(links), springs, torsions, q, u)


def _parents_by_depth(n: int, rng: random.Random) -> list[int]:
    """Parents of a random tree whose links are numbered by their distance from the ground."""
    grown = [GROUND]
    depth = [1]
    for k in range(1, n):
        parent = rng.randrange(max(0, k - 6), k)
        grown.append(parent)
        depth.append(depth[parent] + 1)
    order = sorted(range(n), key=depth.__getitem__)
    place = {old: new for new, old in enumerate(order)} | {GROUND: GROUND}
    return [place[grown[old]] for old in order]


def random_state(n: int, *, seed: int = 1) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Coordinates [rad or m] and velocities in which nothing cancels."""
    rng = random.Random(seed)
    q = tuple(rng.uniform(-1.5, 1.5) for _ in range(n))
    return q, tuple(rng.uniform(-1, 1) for _ in range(n))
