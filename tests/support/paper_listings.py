"""The systems of S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody", in their lists.

The listings of sections 5.1 and 5.2 are as printed; what they leave to the reader (masses of
SpiderFLOAT, gravity), and the other systems, are from the authors' files.
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


def small_double_pendulum() -> dict[str, Any]:
    """Section 4.2.1: two links of 1 m, released at -0.4 rad ("23 degrees"); 30 s."""
    joints = [[0, 1], [1, 2]]
    types = ['R', 'R']
    parent_cg_to_joint = [[0, 0], [0, -0.5]]
    joint_to_child_cg = [[0, -0.5], [0, -0.5]]
    prismatic_direction = [[np.nan, np.nan], [np.nan, np.nan]]
    ic = np.array([-0.4, -0.4, 0, 0])
    g = 9.81
    m0 = np.ones(2)
    J0 = np.ones(2)
    return locals()


def cart() -> dict[str, Any]:
    """Section 4.2.2: a double pendulum on a cart that is pushed; 100 s."""
    t = sym.Symbol("t", real=True)
    joints = [[0, 1], [1, 2], [2, 3]]
    types = ['P', 'R', 'R']
    parent_cg_to_joint = [[0, 0], [0, 0], [0, -0.5]]
    joint_to_child_cg = [[0, 0.125], [0, -0.625], [0, -0.5]]
    prismatic_direction = [[1, 0], [np.nan, np.nan], [np.nan, np.nan]]
    Force = {"CG": [[1, 3*sym.cos(1.5*t), 0, 0]]}
    ic = np.zeros(6)
    g = 9.81
    m0 = np.ones(3)
    J0 = np.ones(3)
    del t
    return locals()


def flexible_pendulum() -> dict[str, Any]:
    """Section 4.4: a mass on a line of stiffness EA / l0; 80 s."""
    joints = [[0, 1]]
    types = ['F']
    parent_cg_to_joint = [[10, -100.00216312373226]]
    joint_to_child_cg = [[np.nan, np.nan]]
    prismatic_direction = [[np.nan, np.nan]]
    Initial_Points = {"GR": [[0, 0]], "BD": {}}
    Force = {"TensionSpring": [(('GR00', 'CG11'), [100.5, 1e9/100.5])]}
    g = 9.80665
    m0 = 1e5*np.ones(1)
    J0 = 1e5*np.ones(1)
    return locals()


def flap() -> dict[str, Any]:
    """Section 4.1, Ginsberg's example 7.13: an inverted pendulum between two springs; 10 s."""
    L, a, b = 2, 0.5, 1
    joints = [[0, 1]]
    types = ['R']
    parent_cg_to_joint = [[0, 0]]
    joint_to_child_cg = [[0, L/2]]
    prismatic_direction = [[np.nan, np.nan]]
    Initial_Points = {"GR": [[-b, 0], [b, 0]], "BD": {1: [[0, a-L/2], [0, L/2]]}}
    Force = {"TensionSpring": [(('BD10', 'GR00'), [np.sqrt(a**2 + b**2), 100]),
                               (('BD10', 'GR01'), [np.sqrt(a**2 + b**2), 100])]}
    ic = np.array([0.05, 0])
    g = 9.81
    m0 = np.ones(1)
    J0 = np.ones(1)/12
    del L, a, b
    return locals()


def foswec() -> dict[str, Any]:
    """Two flaps on a floating base; 10 s. The stiffness k of the authors' file is 1 N/m."""
    t = sym.Symbol("t", real=True)
    Reference_frame_Origin = np.array([0, 0.91])
    joints = [[0, 1], [1, 2], [1, 3]]
    types = ['F', 'R', 'R']
    parent_cg_to_joint = [[0, 0], [0.64, 0], [-0.64, 0]]
    joint_to_child_cg = [[np.nan, np.nan], [0, 0.17], [0, 0.17]]
    prismatic_direction = [[np.nan, np.nan], [np.nan, np.nan], [np.nan, np.nan]]
    Initial_Points = {"GR": [[0.75, -0.91], [-0.75, -0.91]], "BD": {1: [[0.75, 0], [-0.75, 0]]}}
    Force = {
        "CG": [[1, 0, 0.1*sym.exp(-t), 0]],
        "TensionSpring": [(('GR00', 'BD10'), [5, 1]), (('GR01', 'BD11'), [5, 1])],
        "TensionDamper": [(('GR00', 'BD10'), 1), (('GR01', 'BD11'), 1)],
        "TorsionSpring": [((1, 2), [0, 10]), ((1, 3), [0, 10])],
        "TorsionDamper": [((1, 2), 0), ((1, 3), 0)],
    }
    ic = np.zeros(10)
    g = 0.
    m0 = np.ones(3)
    J0 = 2.*np.ones(3)
    del t
    return locals()
