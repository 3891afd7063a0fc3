"""Descriptions of FMUs that there are not, for what needs no running FMU."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.units import Unit, parse_unit


def unit(text: str) -> Unit | None:
    if text == "degC":
        return replace(parse_unit("K"), text=text)
    return parse_unit(text) if text else None


def described(name: str, *variables: tuple[str, str, str]) -> Description:
    """A description of (name, causality, unit) variables that depend on nothing."""
    table = {
        n: Variable(
            n,
            k,
            "Real",
            c,
            "continuous",
            None,
            u,
            unit(u),
            273.15 if u == "degC" else 0.0,
            "",
            None,
        )
        for k, (n, c, u) in enumerate(variables)
    }
    outputs = {n: frozenset[str]() for n, c, _ in variables if c != "input"}
    return Description(Path(f"{name}.fmu"), name, "", table, outputs, outputs, frozenset(), {}, {})
