"""Panels: a surface of triangles and quadrilaterals as two arrays, and what follows from them.

Everything here is NumPy only. World frame, reference pose, z = 0 the still-water level, normals
into the water.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RELATIVE_TOLERANCE = 1e-5  # of the extent: coordinates closer than this coincide


@dataclass(frozen=True)
class Panels:
    """A surface: `vertices` (nv, 3) in m, `faces` (nf, 4) indices; a triangle repeats its last."""

    vertices: np.ndarray
    faces: np.ndarray

    @property
    def size(self) -> float:
        """Largest extent [m]."""
        return float(np.ptp(self.vertices, axis=0).max()) if len(self.vertices) else 0.0

    @property
    def corners(self) -> np.ndarray:
        """Corners of the panels, (nf, 4, 3) in m."""
        return self.vertices[self.faces]

    @property
    def centers(self) -> np.ndarray:
        """Means of the panels' distinct corners, (nf, 3) in m."""
        corners = self.corners
        triangle = (self.faces[:, 2] == self.faces[:, 3])[:, None]
        return np.where(triangle, corners[:, :3].mean(axis=1), corners.mean(axis=1))

    @property
    def radii(self) -> np.ndarray:
        """Distances [m] of the panels' farthest corners from their centres, (nf,)."""
        return np.linalg.norm(self.corners - self.centers[:, None], axis=2).max(axis=1)

    @property
    def triangles(self) -> np.ndarray:
        """The panels as triangles, (2·nf, 3, 3) in m; those of triangular panels may be empty."""
        corners = self.corners
        return np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])

    @property
    def triangle_faces(self) -> np.ndarray:
        """The panels as triangles, (nt, 3) indices, none of them empty."""
        a, b, c, d = self.faces.T
        triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
        return triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]

    @property
    def normals(self) -> np.ndarray:
        """Normals of the panels, (nf, 3), as long as their areas [m2]."""
        corners = self.corners
        return 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])

    def merged(self) -> Panels:
        """The same surface: coincident vertices made one; no empty panels, no vertices of none."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components
        from scipy.spatial import KDTree

        count = len(self.vertices)
        reach = RELATIVE_TOLERANCE * max(self.size, 1e-12)
        pairs = KDTree(self.vertices).query_pairs(reach, output_type="ndarray")
        near = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
        _, where = connected_components(near, directed=False)
        _, first = np.unique(where, return_index=True)
        faces = [list(dict.fromkeys(face)) for face in where[self.faces].tolist()]
        filled = [[*face, face[-1]][:4] for face in faces if len(face) > 2]
        used, places = np.unique(np.array(filled, dtype=int), return_inverse=True)
        return Panels(self.vertices[first][used], places.reshape(-1, 4))

    def divided(self, parts: int) -> Panels:
        """The same surface, each side of a panel divided into so many `parts` [1]."""
        if parts == 1:
            return self
        corners = self.corners
        triangle = self.faces[:, 2] == self.faces[:, 3]
        way = np.linspace(0.0, 1.0, parts + 1)
        pieces: list[np.ndarray] = []
        for i, j in np.ndindex(parts, parts):
            u, v = way[i : i + 2], way[j : j + 2]
            of_four = [(u[0], v[0]), (u[1], v[0]), (u[1], v[1]), (u[0], v[1])]
            a, b, c, d = corners[~triangle].swapaxes(0, 1)
            pieces.append(
                np.stack(
                    [
                        (1 - s) * (1 - t) * a + s * (1 - t) * b + s * t * c + (1 - s) * t * d
                        for s, t in of_four
                    ],
                    axis=1,
                )
            )
            if i + j >= parts:
                continue
            a, b, c, _ = corners[triangle].swapaxes(0, 1)
            of_three = [(u[0], v[0]), (u[1], v[0]), (u[0], v[1])]
            upside = [(u[1], v[0]), (u[1], v[1]), (u[0], v[1])]
            for three in (of_three, upside) if i + j < parts - 1 else (of_three,):
                points = [(1 - s - t) * a + s * b + t * c for s, t in three]
                pieces.append(np.stack([*points, points[-1]], axis=1))
        found = np.concatenate(pieces)
        index = np.arange(4 * len(found)).reshape(-1, 4)
        return Panels(found.reshape(-1, 3), index).merged()

    def selected(self, mask: np.ndarray) -> Panels:
        """The panels where `mask` (nf,), booleans, is true."""
        return Panels(self.vertices, self.faces[mask])

    def mirrored(self, axis: int) -> Panels:
        """The mirror image in the plane x = 0 (axis 0) or y = 0 (axis 1)."""
        vertices = self.vertices * np.where(np.arange(3) == axis, -1.0, 1.0)
        return Panels(vertices, self.faces[:, ::-1])

    @property
    def reversed(self) -> Panels:
        """The same surface with its normals turned round."""
        return Panels(self.vertices, self.faces[:, ::-1])

    def shells(self) -> list[Panels]:
        """The parts that share no edge with each other, each with vertices of its own."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        firsts: dict[tuple[int, int], int] = {}
        pairs = []
        for number, face in enumerate(self.faces.tolist()):
            for a, b in zip(face, [*face[1:], face[0]], strict=True):
                if a != b:
                    pairs.append((number, firsts.setdefault((min(a, b), max(a, b)), number)))
        rows, columns = np.array(pairs).T
        count = len(self.faces)
        shared = coo_array((np.ones(len(pairs)), (rows, columns)), shape=(count, count))
        number, label = connected_components(shared, directed=False)
        found = []
        for k in range(number):
            used, faces = np.unique(self.faces[label == k], return_inverse=True)
            found.append(Panels(self.vertices[used], faces.reshape(-1, 4)))
        return found

    def edges(self) -> dict[tuple[int, int], list[int]]:
        """Every edge (lower, upper vertex) with +1 or −1 for each panel that runs along it."""
        found: dict[tuple[int, int], list[int]] = {}
        for face in self.faces.tolist():
            for a, b in zip(face, [*face[1:], face[0]], strict=True):
                if a != b:
                    found.setdefault((min(a, b), max(a, b)), []).append(1 if a < b else -1)
        return found

    def half(self, axis: int) -> Panels | None:
        """The panels on the positive side of the plane x = 0 (axis 0) or y = 0 (axis 1).

        None if the surface is not its own mirror image in that plane.
        """
        from scipy.spatial import KDTree

        reach = 10 * RELATIVE_TOLERANCE * self.size
        centers = self.centers
        upper = centers[:, axis] > 0
        outwards = np.where(upper[:, None], 1, -1) * self.corners[:, :, axis]
        if 2 * upper.sum() != len(centers) or outwards.min(initial=0.0) < -reach:
            return None
        mirrored = centers[~upper] * np.where(np.arange(3) == axis, -1.0, 1.0)
        distance, partner = KDTree(centers[upper]).query(mirrored)
        if distance.max(initial=0.0) > reach or len(np.unique(partner)) < len(mirrored):
            return None
        return self.selected(upper)


def joined(*parts: Panels) -> Panels:
    """One surface of several, coincident vertices made one."""
    offsets = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    faces = [part.faces + offset for part, offset in zip(parts, offsets, strict=True)]
    return Panels(np.concatenate([p.vertices for p in parts]), np.concatenate(faces)).merged()


def grid(points: np.ndarray) -> Panels:
    """Panels between the `points` (nu, nv, 3) [m]; their normals point along ∂/∂u × ∂/∂v."""
    nu, nv, _ = points.shape
    index = np.arange(nu * nv).reshape(nu, nv)
    corners = (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
    faces = np.stack([c.ravel() for c in corners], axis=1)
    return Panels(points.reshape(-1, 3), faces)
