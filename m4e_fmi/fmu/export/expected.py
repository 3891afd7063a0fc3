"""The description that an FMU will have, known before it is built."""

from __future__ import annotations

from pathlib import Path

from m4e_fmi.fmu.export.build import asked, described, shown
from m4e_fmi.fmu.export.description.description import FmuVariable, ModelDescription, PythonSource
from m4e_fmi.fmu.export.options import Options
from m4e_fmi.fmu.importer.reading import OWN_TOOL, Description, Variable
from m4e_fmi.program import Program
from m4e_fmi.units import parse_unit


def expected_description(source: Program | PythonSource, path: Path) -> Description:
    """The description of the FMU of `source` that is to be built at `path`.

    It has the variables and which input is the rate of which; of dependencies and of what the FMU
    can do it tells nothing.
    """
    options = Options()
    if isinstance(source, Program):
        found = described(shown(source, options), options)
    else:
        found = asked(source.description, options)
    return _description(found, path)


def _description(given: ModelDescription, path: Path) -> Description:
    count: dict[str, int] = {}
    variables = {}
    for variable in given.variables:
        reference = count[variable.type] = count.get(variable.type, -1) + 1
        variables[variable.name] = _variable(variable, reference)
    rates = {v.derivative_of: v.name for v in given.variables if v.derivative_of is not None}
    inputs = {v.name for v in given.variables if v.causality == "input"}
    return Description(
        path=path,
        identifier=given.name,
        guid="",
        variables=variables,
        dependencies={},
        initial_dependencies={},
        undeclared=frozenset(),
        output_derivatives={},
        input_derivatives={x: v for x, v in rates.items() if {x, v} <= inputs},
        tool=OWN_TOOL,
    )


def _variable(given: FmuVariable, reference: int) -> Variable:
    is_real = given.type == "Real"
    return Variable(
        name=given.name,
        value_reference=reference,
        type=given.type,
        causality=given.causality,
        variability=given.variability,
        initial="exact" if given.causality == "input" else given.initial,
        unit=given.unit if is_real else "",
        dimension=parse_unit(given.unit) if is_real and given.unit else None,
        offset=0.0,
        description=given.description,
        derivative_of=given.derivative_of,
        nominal=given.nominal,
        fmi_type=given.type,
        start=None if given.start is None else str(given.start),
        minimum=given.minimum,
        maximum=given.maximum,
    )
