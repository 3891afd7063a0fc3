"""Which variables of two files belong together, and in which unit they are compared."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from m4e_fmi.errors import InputError, Problem, suggestion, unknown_names
from m4e_fmi.results.compared_file import ComparedFile, Quantity
from m4e_fmi.results.foreign_table import heading
from m4e_fmi.units import parse_unit

_MOST_SHOWN = 4


@dataclass(frozen=True)
class Pair:
    """A variable and its reference; the latter's values times `factor` are in `unit`."""

    variable: Quantity
    reference: Quantity
    unit: str
    factor: float
    notes: tuple[str, ...]


def matched(
    one: ComparedFile,
    reference: ComparedFile,
    *,
    mapping: Mapping[str, str],
    variables: Collection[str] | None,
) -> list[Pair]:
    """Pairs of variables: those that `mapping` names, then those of the same name.

    `mapping` leads from names in the reference, with or without unit, to ours. A name in the
    reference without a component stands for the only variable of ours that is called so.
    `variables` are those of ours that are wanted, None for all. InputError with all names that are
    unknown or without a counterpart, and all units that do not fit.
    """
    mapping = {_plain(name, reference): other for name, other in mapping.items()}
    problems = unknown_names(
        mapping, reference.quantities, f"{reference.path.name} has no variable", "variables"
    )
    ours = [*mapping.values(), *(variables or ())]
    problems += unknown_names(
        dict.fromkeys(ours), one.quantities, f"{one.path.name} has no variable", "variables"
    )
    twice = {name for name in mapping.values() if list(mapping.values()).count(name) > 1}
    problems += [Problem(f"{name!r} is mapped twice", "map it once") for name in sorted(twice)]
    if problems:
        raise InputError(dict.fromkeys(problems))
    found = {name: other for other, name in mapping.items()}
    notes = dict[str, str]()
    for name in reference.quantities:
        if name in mapping:
            continue
        if name in one.quantities:
            found.setdefault(name, name)
        elif (alone := _alone(name, one)) and alone not in found:
            found[alone] = name
            notes[alone] = f"{name!r} of the reference is taken as {alone}, the only one so called"
    wanted = [name for name in one.quantities if variables is None or name in variables]
    problems = [_without(name, reference) for name in variables or () if name not in found]
    if not problems and not any(name in found for name in wanted):
        problems = [_nothing(one, reference)]
    if problems:
        raise InputError(problems)
    return _in_units(
        [
            (one.quantities[n], reference.quantities[found[n]], notes.get(n))
            for n in wanted
            if n in found
        ]
    )


def _plain(name: str, reference: ComparedFile) -> str:
    """The name without its unit, if a variable of the reference is so called."""
    plain = heading(name)[0]
    known = reference.quantities
    return plain if name not in known and plain in known else name


def _alone(name: str, one: ComparedFile) -> str | None:
    """The only variable ``component.name``."""
    found = [n for n in one.quantities if n.partition(".")[2] == name]
    return found[0] if len(found) == 1 else None


def _without(name: str, reference: ComparedFile) -> Problem:
    near = suggestion(name, reference.quantities, "variables")
    remedy = f"name its counterpart with --map REFERENCE={name}; {near}"
    return Problem(f"{reference.path.name} has no variable {name!r}", remedy)


def _nothing(one: ComparedFile, reference: ComparedFile) -> Problem:
    def shown(file: ComparedFile) -> str:
        names = list(file.quantities)
        more = ", …" if len(names) > _MOST_SHOWN else ""
        return f"{file.path.name} has {', '.join(names[:_MOST_SHOWN])}{more}"

    message = f"no variable has the same name in both: {shown(one)}; {shown(reference)}"
    return Problem(message, "say which belong together: --map REFERENCE=COMPONENT.VARIABLE")


def _in_units(pairs: list[tuple[Quantity, Quantity, str | None]]) -> list[Pair]:
    found, problems = [], []
    for variable, reference, note in pairs:
        notes = [note] if note else []
        try:
            unit, factor, told = _unit(variable, reference)
        except ValueError as error:
            remedy = "write the unit behind the name, as in 'name [unit]'"
            problems.append(Problem(f"{variable.name} and {reference.name}: {error}", remedy))
            continue
        notes += [told] if told else []
        found.append(Pair(variable, reference, unit, factor, tuple(notes)))
    if problems:
        raise InputError(problems)
    return found


def _unit(variable: Quantity, reference: Quantity) -> tuple[str, float, str]:
    """Unit, the reference's factor, and what was done; ValueError if the units do not fit."""
    own, other = variable.unit, reference.unit
    if own is None and other is None:
        return "", 1.0, "no unit in either file: compared as they are"
    if other is None or own is None:
        known = str(own or other)
        name = reference.name if other is None else variable.name
        return known, 1.0, f"{name!r} says no unit: taken as {known}"
    if own == other:
        return own, 1.0, ""
    mine, theirs = parse_unit(own), parse_unit(other)
    if not mine.same_dimension(theirs):
        raise ValueError(f"{own} and {other} are of different dimension")
    factor = theirs.factor / mine.factor
    told = "" if factor == 1.0 else f"{reference.name!r} converted from {other} to {own}"
    return own, factor, told
