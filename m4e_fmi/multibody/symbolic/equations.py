"""The equations of motion as SymPy expressions: what people read.

Everything is computed when it is first asked for, and simplified on demand only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.errors import InputError, suggestion
from m4e_fmi.model import Model, as_model
from m4e_fmi.model.elements import neutral_mass, neutral_symbol
from m4e_fmi.multibody.assembly import (
    Accelerations,
    Assembly,
    Scalars,
    assemble,
    kinetic_energy,
    load_powers,
    potential_energy,
)
from m4e_fmi.multibody.closed_form import (
    Columns,
    column_rates,
    forcing,
    mass_matrix,
    outwards,
    reactions,
    velocity_transformation,
)
from m4e_fmi.multibody.declaration import inputs_of
from m4e_fmi.multibody.recording import add_outputs
from m4e_fmi.multibody.topology import topology
from m4e_fmi.program import AnyScalar, Variable
from m4e_fmi.shown import listing
from m4e_fmi.space import TURN

if TYPE_CHECKING:
    import sympy

MOST_COORDINATES, LONGEST = 12, 20_000
"""Of models whose equations pages and notebooks have: coordinates, and characters of LaTeX."""
MOST_SIMPLIFIED = 20_000
"""Symbols and operations of an expression that is simplified, in some seconds."""


class Equations:
    """Symbolic equations of a model: mass_matrix · u̇ = forcing, with q̇ = u.

    `model` may be the path of a model file.
    Symbols are real: coordinates `Theta_k`, `S_k`, `X_k`, `Z_k`, velocities `ThetaD_k`, … and
    accelerations `ThetaDD_k`, … of body k, the time `t`, the model's parameters, `A_i_j` for added
    mass, `neutral_mass_<body>` for a mass that is "neutral". A table is an undefined function of t
    by its name. `inputs` names inputs of the model's program that act as well, as symbols of that
    name; InputError if it has no such input. `simplify` takes the
    shortest of every expression as it is, expanded, and with sums of angles; InputError if one is
    too long for it.
    """

    def __init__(
        self, model: Model | str | Path, inputs: Sequence[str] = (), *, simplify: bool = False
    ) -> None:
        self.model = as_model(model)
        self.inputs = tuple(inputs)
        self.simplify = simplify
        self.topology = topology(self.model)

    @cached_property
    def neutral_bodies(self) -> list[str]:
        """Bodies whose mass is that of the displaced water."""
        return [name for name, body in self.model.bodies.items() if body.is_neutral]

    @cached_property
    def q(self) -> sympy.Matrix:
        """Coordinates, n×1."""
        return _symbols(self.topology.coordinate_names)

    @cached_property
    def u(self) -> sympy.Matrix:
        """Velocities, n×1."""
        return _symbols(self.topology.velocity_names)

    @cached_property
    def u_dot(self) -> sympy.Matrix:
        """Accelerations, n×1: symbols, to write what depends on them."""
        return _symbols(self.topology.acceleration_names)

    @cached_property
    def assembly(self) -> Assembly:
        """The model in motion over SymPy's symbols; decimal numbers are exact fractions."""
        import sympy

        def symbol(name: str) -> AnyScalar:
            return sympy.Symbol(name, real=True)

        def exact(value: float) -> AnyScalar:
            return sympy.pi if value == math.pi else sympy.Rational(repr(value))

        wet = len(self.topology.components) * sum(
            self.model.bodies[link.body].added_mass for link in self.topology.links
        )
        scalars = Scalars(
            q=self.q.flat(),
            u=self.u.flat(),
            time=symbol("t"),
            parameters={name: symbol(name) for name in self.model.parameters}
            | {neutral_mass(body): symbol(neutral_symbol(body)) for body in self.neutral_bodies},
            **self._acting(),
            added_mass=[[symbol(f"A_{i + 1}_{j + 1}") for j in range(wet)] for i in range(wet)],
            number=exact,
            table=lambda name, _, time: sympy.Function(name)(time),
        )
        return assemble(self.model, self.topology, scalars)

    def _acting(self) -> dict[str, AnyScalar]:
        """Inputs: symbols for those that are wanted, zero for the others."""
        import sympy

        known: list[str] = []

        def scalar(variable: Variable) -> AnyScalar:
            known.append(variable.name)
            wanted = variable.name in self.inputs
            return sympy.Symbol(variable.name, real=True) if wanted else 0

        found = inputs_of(self.model, self.topology, scalar)
        unknown = [name for name in self.inputs if name not in known]
        if unknown:
            message = f"{self.model.name} has no input {', '.join(unknown)}"
            raise InputError.single(message, suggestion(unknown[0], known))
        return found

    @cached_property
    def B(self) -> sympy.Matrix:
        """Velocity transformation: (v_x, v_z, ω) of each body = B u, 3N×n; in space (v, ω)."""
        bodies = self.assembly.frames
        return self._stacked(
            [velocity_transformation(self.topology, bodies, k) for k in range(len(bodies))]
        )

    @cached_property
    def B_dot(self) -> sympy.Matrix:
        """Time derivative of B."""
        bodies, u = self.assembly.frames, self.u.flat()
        return self._stacked(
            [column_rates(self.topology, bodies, u, k) for k in range(len(bodies))]
        )

    @cached_property
    def mass_matrix(self) -> sympy.Matrix:
        """Bᵀ(𝓜 + A)B, n×n."""
        n = len(self.topology.velocity_names)
        return self._matrix(
            [[row.get(k, 0) for k in range(n)] for row in mass_matrix(self.assembly)]
        )

    @cached_property
    def forcing(self) -> sympy.Matrix:
        """Bᵀ(g + g_g) − Bᵀ(𝓜 + A)Ḃu, n×1."""
        return self._matrix([[entry] for entry in forcing(self.assembly)])

    @cached_property
    def reactions(self) -> dict[str, sympy.Matrix]:
        """By joint, (F_x, F_z [N], M_y [N·m]) on its child, 3×1, in space (F, M), 6×1.

        See `closed_form.Reaction`. Functions of q, u and `u_dot`. A floating joint exerts nothing
        and is left out.
        """
        found = reactions(self.assembly, self._moving)
        components = self.topology.components
        return {
            r.joint: self._matrix([[(*r.force, *r.moment)[c]] for c in components]) for r in found
        }

    @cached_property
    def _moving(self) -> Accelerations:
        return outwards(self.assembly, self.u_dot.flat())

    @cached_property
    def outputs(self) -> dict[str, sympy.Expr]:
        """Every output of the model's program by name, as a function of q, u and `u_dot`."""
        values: dict[str, sympy.Expr] = {}

        def take(variable: Variable, value: AnyScalar) -> None:
            values[variable.name] = self._expression(value)

        add_outputs(take, self.assembly, self._moving)
        return values

    @cached_property
    def kinetic_energy(self) -> sympy.Expr:
        """½ vᵀ(𝓜 + A)v [J]."""
        return self._expression(kinetic_energy(self.assembly))

    @cached_property
    def potential_energy(self) -> sympy.Expr:
        """Of gravity (zero at Z = 0) and of springs that have one [J]."""
        return self._expression(potential_energy(self.assembly))

    @cached_property
    def load_powers(self) -> dict[str, sympy.Expr]:
        """Power [W] by which each load changes the total energy; pure springs are left out."""
        return {name: self._expression(power) for name, power in load_powers(self.assembly).items()}

    @cached_property
    def positions(self) -> sympy.Matrix:
        """(x, z) of every centre of gravity [m], N×2; in space (x, y, z), N×3."""
        axes = [c for c in self.topology.components if c < TURN]
        return self._matrix([[f.position[c] for c in axes] for f in self.assembly.frames])

    def _expression(self, value: AnyScalar) -> sympy.Expr:
        """A scalar as an expression, simplified if asked for."""
        import sympy

        from m4e_fmi.multibody.symbolic.printing import tree_size

        made = sympy.sympify(value, strict=True)
        if not self.simplify:
            return made
        if (size := tree_size(made, {})) > MOST_SIMPLIFIED:
            message = f"{self.model.name}: an expression of {size:,} operations is not simplified"
            raise InputError.single(message, "leave it as it is")
        return min(_candidates(made), key=lambda form: tree_size(form, {}))

    def _matrix(self, rows: list[list[AnyScalar]]) -> sympy.Matrix:
        import sympy

        return sympy.Matrix([[self._expression(entry) for entry in row] for row in rows])

    def _stacked(self, bodies: list[Columns]) -> sympy.Matrix:
        """The rows of every body that its motion can have as one matrix."""
        n, nothing = len(self.topology.velocity_names), [0] * (2 * TURN)
        return self._matrix(
            [
                [body.get(column, nothing)[c] for column in range(n)]
                for body in bodies
                for c in self.topology.components
            ]
        )

    def text(self, *, latex: bool = False, reactions: bool = False) -> str:
        """The equations as a page of text, or of LaTeX: see `printing.equations_text`."""
        from m4e_fmi.multibody.symbolic.printing import equations_text

        return equations_text(self, latex=latex, reactions=reactions)

    def _repr_latex_(self) -> str | None:
        """The lines of the page in LaTeX; None if they are too long, which shows the `repr`."""
        if len(self.topology.coordinate_names) > MOST_COORDINATES:
            return None
        lines = self.text(latex=True).splitlines()
        made = "\n".join(line for line in lines if not line.startswith("%"))
        return made if len(made) <= LONGEST else None

    def __str__(self) -> str:
        few = len(self.topology.coordinate_names) <= MOST_COORDINATES
        return self.text() if few else repr(self)

    def __repr__(self) -> str:
        title = f"Equations of {self.model.name!r}: mass_matrix · u̇ = forcing, q̇ = u"
        names = self.topology.coordinate_names
        return listing(title, q=names, u=self.topology.velocity_names, inputs=self.inputs)


def _candidates(value: sympy.Expr) -> tuple[sympy.Expr, ...]:
    """As it is, expanded, with sin² = 1 − cos², with sums of angles.

    What has roots or quotients is only as it is: expanding makes it longer.
    """
    import sympy
    from sympy.simplify.fu import TR5, TR8

    if not all(power.exp.is_Integer and power.exp > 0 for power in value.atoms(sympy.Pow)):
        return (value,)
    expanded = sympy.expand(value)
    squares = sympy.expand(TR5(expanded))
    return value, expanded, squares, sympy.expand(TR8(squares))


def _symbols(names: tuple[str, ...]) -> sympy.Matrix:
    import sympy

    return sympy.Matrix([sympy.Symbol(name, real=True) for name in names])
