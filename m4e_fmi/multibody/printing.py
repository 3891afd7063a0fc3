"""The equations of motion as text or LaTeX."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from m4e_fmi.multibody.equations import Equations


def equations_text(equations: Equations, *, latex: bool = False, reactions: bool = False) -> str:
    """All of `equations`: coordinates, B, Ḃ, mass matrix, forcing, energies; zeros left out.

    With `reactions` those of the joints as well, as functions of q, u and the accelerations.
    """
    import sympy

    tree = equations.topology
    names = _latex_names(equations)
    show = partial(sympy.latex, symbol_names=names) if latex else sympy.sstr
    title = f"{equations.model.name}: {equations.model.description}"
    lines = [" ".join(title.split()), ""]
    for link in tree.links:
        held = ", ".join(tree.coordinate_names[k] for k in link.coordinates)
        holder = f"{link.joint.type} joint {link.joint_name!r} to {link.joint.parent}"
        lines.append(f"body {link.number}: {link.body:<16} {holder:<40} {held}")
    parts = [
        ("Velocity transformation B: v = B u, rows (v_x, v_z, omega) of each body", "B"),
        ("Its time derivative: dv/dt = B du/dt + B_dot u", "B_dot"),
        ("Mass matrix M = B^T (M_bodies + A) B", "mass_matrix"),
        ("Forcing f = B^T (g + g_g) - B^T (M_bodies + A) B_dot u", "forcing"),
    ]
    letters = {"B": "B", "B_dot": r"\dot{B}" if latex else "B_dot", "mass_matrix": "M"}
    lines += ["", "Equations of motion: M(q) du/dt = f(t, q, u),  dq/dt = u"]
    for title, attribute in parts:
        matrix = getattr(equations, attribute)
        letter = letters.get(attribute, "f")
        lines += ["", title, *_entries(matrix, letter, show, latex=latex)]
    energies = (("T", equations.kinetic_energy), ("V", equations.potential_energy))
    lines += ["", "Kinetic and potential energy"]
    lines += [_line(letter, show(value), latex=latex) for letter, value in energies]
    if equations.load_powers:
        lines += ["", "Power of loads that changes T + V"]
        powers = equations.load_powers.items()
        lines += [_line(_power_name(name, latex=latex), show(p), latex=latex) for name, p in powers]
    if reactions:
        lines += ["", "Force (x, z) and moment (y) of each joint on its child, at the joint"]
        for joint, wrench in equations.reactions.items():
            for axis, entry in zip("xzy", wrench.flat(), strict=True):
                lines.append(
                    _line(_reaction_name(joint, axis, latex=latex), show(entry), latex=latex)
                )
    if latex:
        lines = [line if line.startswith("\\[") else f"% {line}".rstrip() for line in lines]
    return "\n".join(lines)


def _latex_names(equations: Equations) -> dict[Any, str]:
    """How coordinates and velocities are written: Theta_1 → \\theta_{1}, ThetaD_1 → \\dot{…}."""
    letters = {"Theta": r"\theta", "Phi": r"\varphi", "S": "s", "X": "x", "Z": "z"}
    result = {}
    rows = zip(equations.q.flat(), equations.u.flat(), equations.u_dot.flat(), strict=True)
    for q, u, u_dot in rows:
        letter, number = q.name.split("_")
        result[q] = f"{letters[letter]}_{{{number}}}"
        result[u] = rf"\dot{{{letters[letter]}}}_{{{number}}}"
        result[u_dot] = rf"\ddot{{{letters[letter]}}}_{{{number}}}"
    return result


def _entries(matrix: Any, letter: str, show: Callable[[Any], str], *, latex: bool) -> list[str]:
    lines = []
    for i in range(matrix.rows):
        for j in range(matrix.cols):
            if matrix[i, j] != 0:
                index = f"{i + 1}" if matrix.cols == 1 else f"{i + 1},{j + 1}"
                name = f"{letter}_{{{index}}}" if latex else f"{letter}[{index}]"
                lines.append(_line(name, show(matrix[i, j]), latex=latex))
    return lines or ["  (all zero)"]


def _power_name(load: str, *, latex: bool) -> str:
    escaped = load.replace("_", r"\_")
    return rf"P_{{\mathrm{{{escaped}}}}}" if latex else f"P[{load}]"


def _reaction_name(joint: str, axis: str, *, latex: bool) -> str:
    letter = "M" if axis == "y" else "R"
    if not latex:
        return f"{letter}[{joint}].{axis}"
    escaped = joint.replace("_", r"\_")
    return rf"{letter}_{{\mathrm{{{escaped}}},{axis}}}"


def _line(name: str, value: str, *, latex: bool) -> str:
    return rf"\[ {name} = {value} \]" if latex else f"  {name} = {value}"
