"""Integrals of a pressure over the part of a surface where it is positive.

The pressure is given as a head [m of water] at the vertices and linear on each triangle between
them; a triangle is cut along the line where it vanishes. These integrals are exact. In still water
the head is the depth, which *is* linear: then the whole is exact for the triangles, and the sums of
a closed surface are those of the body below the water. Elsewhere the error is of second order in
the size of the triangles.

The mean over a triangle of λ_a h, λ_a the barycentric coordinate of corner a, is (h_a + Σh)/12. A
corner i on its own side of the waterline cuts off a triangle of which the edges to j and k are the
shares q_j = |h_i|/(|h_i| + |h_j|) and q_k: its mean is |h_i| q_j q_k (4 − q_j − q_k, q_j, q_k)/12,
for the corners i, j, k. Wet triangles have the first, those with one wet corner the second, those
with one dry corner the sum of both.
"""

from __future__ import annotations

import numpy as np


class ClippedSurface:
    """A closed surface of `triangles` (nt, 3), corner indices of `vertices` (nv, 3) [m].

    Normals point out of the body. Moments are about the origin of the vertices.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        self.vertices, self._triangles = vertices, triangles
        corners = vertices[triangles]
        area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        moment = np.cross(corners, area[:, None])
        force = np.broadcast_to(area[:, None], moment.shape)
        self._weights = -np.concatenate([force, moment], axis=2) / 12.0  # (nt, 3, 6)
        spread = self._weights + self._weights.sum(axis=1, keepdims=True)
        self._wet = np.zeros((len(vertices), 6))
        np.add.at(self._wet, triangles, spread)

    def wrench(self, head: np.ndarray) -> np.ndarray:
        """Force and moment (6,) [m3, m4] of the positive part of `head` (nv,) [m].

        −∫ h n dA and −∫ r × h n dA, in the axes of the vertices: times ρ g they are N and N.m.
        """
        wet = head > 0.0
        total = np.where(wet, head, 0.0) @ self._wet
        of_corners = wet[self._triangles]
        count = of_corners.sum(axis=1)
        cut = np.flatnonzero((count == 1) | (count == 2))
        if len(cut):
            alone = np.where(count[cut] == 1, of_corners[cut].argmax(1), of_corners[cut].argmin(1))
            total = total + self._beyond(head, cut, alone)
        return total

    def _beyond(self, head: np.ndarray, cut: np.ndarray, alone: np.ndarray) -> np.ndarray:
        """Wrench (6,) [m3, m4] of triangles `cut` (nc,) beyond that of their wet corners' heads.

        `alone` (nc,) are their corners on their own side of the waterline.
        """
        rows = np.arange(len(cut))
        order = (alone[:, None] + np.arange(3)) % 3
        own, second, third = np.abs(head[self._triangles[cut[:, None], order]]).T
        to_second, to_third = own / (own + second), own / (own + third)
        tip = own * to_second * to_third
        shares = np.empty((len(cut), 3))
        shares[rows, order[:, 0]] = tip * (4.0 - to_second - to_third) - 2.0 * own
        shares[rows, order[:, 1]] = tip * to_second - own
        shares[rows, order[:, 2]] = tip * to_third - own
        return np.tensordot(shares, self._weights[cut], axes=2)
