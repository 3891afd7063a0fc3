"""The listings of S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody", as printed.

Sections 5.1 and 5.2; what they leave to the reader (masses of SpiderFLOAT, gravity) is that of the
authors' files.
"""

from __future__ import annotations

# fmt: off
from typing import Any

import numpy as np
import sympy as sym

from m4e_fmi.model import normalize_prismatic


def double_pendulum() -> dict[str, Any]:
    """Section 5.1, the tutorial."""
    Force: dict[str, Any] = {}
    Reference_frame_Origin = np.array([0, 0])

    # Bodies definition
    joints                = [[0, 1], [1, 2]]
    types                 = ['R', 'R']
    parent_cg_to_joint    = [[0, 0], [0, -0.5]]
    joint_to_child_cg     = [[0, -0.5], [0, -0.5]]
    prismatic_direction   = [[np.nan, np.nan], [np.nan, np.nan]]
    prismatic_direction = normalize_prismatic(prismatic_direction)

    # Forces applied at the center of gravity (CG):
    Force["CG"] = [[2, 20, 20, 0]]

    # Torsion springs: tuple containing connected bodies and a
    # list of undeformed length and spring stiffness
    Force["TorsionSpring"] = [((0,1), [-np.pi*0.75, 50.0])]

    # Torsion dampers: tuple containing connected bodies and
    # damping coefficient
    Force["TorsionDamper"] = [((0,1), 5.0), ((1,2), 5)]

    # Initial conditions for position and velocity
    Q0 = [np.pi*0.75, 0.]
    QD0 = [-0.4, 0.]
    ic = np.array(Q0 + QD0)

    # Simulation parameters
    TimeStep = 0.001
    tspan = 10.
    g = 9.81
    gVec = np.ones((len(types),1))
    m0 = np.ones(len(types))
    J0 = np.ones(len(types))

    # Animation settings
    animation_on = 1
    SaveMovieOn = 'double_pendulum.gif'
    plotTstep = 50
    del Q0, QD0
    return locals()


def spiderfloat() -> dict[str, Any]:
    """Section 5.2."""
    Initial_Points: dict[str, Any] = {}
    Force: dict[str, Any] = {}
    t = sym.Symbol("t", real=True)
    Reference_frame_Origin = np.array([0, 0])

    # Bodies definition
    joints = [[0,1], [1,2], [1,3], [2,4], [3,5], [4,6], [5,7]]
    types = ['F', 'R', 'R', 'P', 'P', 'R', 'R']
    parent_cg_to_joint = [[10,6], [0.5,-2], [-0.5,-2],
        [4.5,0], [-4.5,0], [0,0], [0,0]]
    joint_to_child_cg = [[np.nan,np.nan], [5,0], [-5,0],
        [0.5,0], [-0.5,0], [0,1.5], [0,1.5]]
    prismatic_direction = [[np.nan,np.nan], [np.nan,np.nan],
        [np.nan,np.nan], [1,0], [1,0], [np.nan,np.nan],
        [np.nan,np.nan]]
    prismatic_direction = normalize_prismatic(prismatic_direction)

    # Ground points: relative to the reference frame origin
    Initial_Points["GR"] = [[20,0], [0,0]]

    # Body-defined points: relative to the body CG
    Initial_Points["BD"] = {}
    Initial_Points["BD"][1] = [[0.5, -2.5], [-0.5, -2.5],
        [0.5, 5], [-0.5, 5]]
    Initial_Points["BD"][2] = [[4, 0], [4.5, 0]]
    Initial_Points["BD"][3] = [[-4, 0], [-4.5, 0]]

    # Body forces
    # List of lists containing [Body, point ID, Fx, Fz, My]
    Force["PointsBD"] = []

    # Forces applied at the centers of gravity (CG)
    # List of lists containing [Body, Fx, Fz, My]
    Force["CG"] = [
        [1, 0, 1.*sym.cos(t), 0],
        [4, 1.*sym.cos(t), 0, 0],
        [5, -1.*sym.cos(t), 0, 0]
    ]

    # Tension springs (tuple: connecting points, list: [l0, stiffness])
    # BD20: first point of body two in BD entry of
    # Initial_Points dictionary
    Force["TensionSpring"] = [
        (("BD10", "BD20"), [9.0139, 1e-1]),
        (("BD11", "BD30"), [9.0139, 1e-1]),
        (("BD12", "BD21"), [11.8004, 1e-1]),
        (("BD13", "BD31"), [11.8004, 1e-1]),
        (("BD20", "GR00"), [3.0414, 1e-1]),
        (("GR01", "BD30"), [3.0414, 1e-1])
    ]

    # Tension dampers (tuple: connecting points, float: damping coefficient)
    Force["TensionDamper"] = [
        (("GR00", "CG22"), 3),
        (("GR01", "CG33"), 3)
    ]

    # Torsion springs (tuple: connecting bodies, list: [l0, stiffness])
    Force["TorsionSpring"] = [
        ((1, 2), [0, 1.e2]),
        ((1, 3), [0, 1.e2])
    ]

    # Torsion dampers (tuple: connecting bodies, list: damping coefficient)
    Force["TorsionDamper"] = [
        ((1,2), 1.e1),
        ((1,3), 1.e1)
    ]
    g = 0.
    m0 = np.ones(len(types))
    J0 = 2.*np.ones(len(types))
    del t
    return locals()
