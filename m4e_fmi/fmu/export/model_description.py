"""modelDescription.xml, of FMI 2.0 and 3.0, from one table of what an FMU declares.

FMI 3.0 has time as its first variable; what else differs is in a `Form`. Sources: FMI Specification
2.0.4, section 2.2, and 3.0.2, section 2.4. Element order and attributes follow their schemas.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import m4e_fmi
from m4e_fmi.fmu.export.description import FmuVariable, ModelDescription
from m4e_fmi.program import TIME
from m4e_fmi.program.dependence import KINDS
from m4e_fmi.units import BASE_UNITS, parse_unit

XML = "modelDescription.xml"
BUILD = "sources/buildDescription.xml"
LONG = 200
"""Dependencies beyond which FMI 2.0 has no list of all that is known, nor of kinds that are alike:
it reads them the same, and lists of n outputs of n others grow as n²."""
LOG_CATEGORIES = {
    "logStatusWarning": "Messages with status warning.",
    "logStatusDiscard": "Messages with status discard.",
    "logStatusError": "Messages with status error.",
    "logStatusFatal": "Messages with status fatal.",
    "logAll": "All messages.",
}
DECLARATION = "<?xml version='1.0' encoding='UTF-8'?>"
_TIME = FmuVariable(TIME, "s", "Simulation time", causality="independent")


@dataclass(frozen=True)
class _Quantity:
    """A quantity of `unit`; values may be shown in `displays`, and are in `shown` at first."""

    name: str
    unit: str
    displays: tuple[str, ...] = ()
    shown: str | None = None

    @property
    def type_name(self) -> str:
        """Name of the type in the model description."""
        return f"SI.{self.name}"  # no variable may have the name of a type: none begins like this


QUANTITIES = {  # by unit; named as in the Modelica Standard Library, which importers know
    q.unit: q
    for q in (
        _Quantity("Length", "m", ("mm", "km")),
        _Quantity("Velocity", "m/s", ("kn", "km/h")),
        _Quantity("Acceleration", "m/s2"),
        _Quantity("Angle", "rad", ("deg",), "deg"),
        _Quantity("AngularVelocity", "rad/s", ("rpm", "deg/s"), "rpm"),
        _Quantity("AngularAcceleration", "rad/s2", ("deg/s2",), "deg/s2"),
        _Quantity("Mass", "kg", ("t",)),
        _Quantity("MomentOfInertia", "kg.m2", ("t.m2",)),
        _Quantity("Force", "N", ("kN", "MN"), "kN"),
        _Quantity("Torque", "N.m", ("kN.m", "MN.m"), "kN.m"),
        _Quantity("TranslationalSpringConstant", "N/m", ("kN/m",)),
        _Quantity("RotationalSpringConstant", "N.m/rad", ("kN.m/rad", "N.m/deg")),
        _Quantity("TranslationalDampingConstant", "N.s/m", ("kN.s/m",)),
        _Quantity("RotationalDampingConstant", "N.m.s/rad", ("kN.m.s/rad",)),
        _Quantity("Energy", "J", ("kJ", "MJ", "kW.h")),
        _Quantity("Power", "W", ("kW", "MW")),
        _Quantity("Time", "s", ("min", "h")),
        _Quantity("Frequency", "Hz"),
    )
}


@dataclass(frozen=True)
class Form:
    """Form of a kind of model description: version of FMI, its words, and the FMU's abilities.

    `token` is the attribute for the GUID; `unknowns` are the elements for outputs, rates of states,
    and initial unknowns. `abilities` are attributes of both modes, `exchange` (None:
    no model exchange) and `stepping` further ones of model exchange and co-simulation.
    """

    version: str
    token: str
    unknowns: tuple[str, str, str]
    abilities: Mapping[str, str]
    exchange: Mapping[str, str] | None
    stepping: Mapping[str, str]

    @property
    def is_2(self) -> bool:
        """True of FMI 2.0."""
        return self.version == "2.0"


_UNKNOWNS_2 = ("Outputs", "Derivatives", "InitialUnknowns")
_ABILITIES_2 = {
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}
PYTHON = Form(
    version="2.0",
    token="guid",
    unknowns=_UNKNOWNS_2,
    abilities={"needsExecutionTool": "true", **_ABILITIES_2},
    exchange=None,
    stepping={"canHandleVariableCommunicationStepSize": "true"},
)
NATIVE_2 = Form(
    version="2.0",
    token="guid",
    unknowns=_UNKNOWNS_2,
    abilities={
        "needsExecutionTool": "false",
        **_ABILITIES_2,
        "providesDirectionalDerivative": "true",
    },
    exchange={"completedIntegratorStepNotNeeded": "true"},
    stepping={
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "true",
        "maxOutputDerivativeOrder": "1",
    },
)
NATIVE_3 = Form(
    version="3.0",
    token="instantiationToken",
    unknowns=("Output", "ContinuousStateDerivative", "InitialUnknown"),
    abilities={
        "needsExecutionTool": "false",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "true",
        "providesAdjointDerivatives": "true",
    },
    exchange={},
    stepping={
        "canHandleVariableCommunicationStepSize": "true",
        "maxOutputDerivativeOrder": "1",
        "providesIntermediateUpdate": "true",
        "mightReturnEarlyFromDoStep": "false",
        "canReturnEarlyAfterIntermediateUpdate": "true",
        "hasEventMode": "false",
    },
)


def model_description_xml(
    description: ModelDescription,
    form: Form,
    *,
    model_identifier: str,
    sources: Sequence[str] = (),
) -> bytes:
    """The XML text (UTF-8) of `description`.

    Its GUID (FMI 3.0: token) is empty. `sources` are the C files in the FMU that an importer of
    FMI 2.0 compiles. ValueError names a unit that is not understood, or variables of one name.
    """
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": form.version,
            "modelName": description.name,
            form.token: "",
            "description": _legal(description.description),
            "generationTool": f"m4e_fmi {m4e_fmi.__version__}",
            "variableNamingConvention": "structured",
        },
    )
    if form is NATIVE_2:
        root.set("numberOfEventIndicators", "0")
    for mode, more in (("ModelExchange", form.exchange), ("CoSimulation", form.stepping)):
        if more is None:
            continue
        abilities = {"modelIdentifier": model_identifier, **form.abilities, **more}
        if not description.goes_back:
            abilities = {k: v for k, v in abilities.items() if "FMUstate" not in k}
        element = SubElement(root, mode, abilities)
        if form.is_2 and sources:
            files = SubElement(element, "SourceFiles")
            for name in sources:
                SubElement(files, "File", name=name)
    variables = description.variables if form.is_2 else (_TIME, *description.variables)
    reals = [v for v in variables if v.type == "Real"]
    _add_units(root, reals)
    _add_types(root, reals, form)
    categories = SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=text)
    SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(description.stop_time),
        tolerance=repr(description.tolerance),
        stepSize=repr(description.step_size),
    )
    _add_variables(root, variables, form)
    _add_structure(root, description, variables, form)
    return _xml_bytes(root)


def _xml_bytes(root: Element) -> bytes:
    """The document of `root`, indented, in UTF-8."""
    indent(root)
    text = tostring(root, encoding="unicode")  # encoded at once, which takes half the time
    return f"{DECLARATION}\n{text}\n".encode()


def _legal(text: str) -> str:
    """`text` with the characters that XML 1.0 cannot hold replaced."""
    return re.sub("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "\ufffd", text)


def _given(**attributes: str | None) -> dict[str, str]:
    """The attributes that have a value."""
    return {name: value for name, value in attributes.items() if value is not None}


def _add_units(root: Element, reals: Sequence[FmuVariable]) -> None:
    """Add the units of variables, with what their values may be shown in."""
    definitions = SubElement(root, "UnitDefinitions") if reals else root
    for name in sorted({v.unit for v in reals}):
        unit = parse_unit(name)
        element = SubElement(definitions, "Unit", name=name)
        powers = zip(BASE_UNITS, unit.exponents, strict=True)
        base = {base: str(power) for base, power in powers if power}
        if unit.factor != 1.0:
            base["factor"] = repr(unit.factor)
        SubElement(element, "BaseUnit", base)
        chosen = {v.display_unit for v in reals if v.unit == name and v.display_unit}
        offered = QUANTITIES[name].displays if name in QUANTITIES else ()
        for display in sorted({*chosen, *offered}):
            factor = display_factor(name, display)
            SubElement(element, "DisplayUnit", name=display, factor=repr(factor))


def display_factor(unit: str, display: str) -> float:
    """Value in `display` = this · value in `unit`: FMI 2.0.4, section 2.2.2."""
    return parse_unit(unit).factor / parse_unit(display).factor


def _add_types(root: Element, reals: Sequence[FmuVariable], form: Form) -> None:
    """Add the quantities of variables as types."""
    found = [QUANTITIES[unit] for unit in {v.unit for v in reals} if unit in QUANTITIES]
    definitions = SubElement(root, "TypeDefinitions") if found else root
    for quantity in sorted(found, key=lambda q: q.name):
        name = quantity.type_name
        facts = _given(quantity=quantity.name, unit=quantity.unit, displayUnit=quantity.shown)
        if form.is_2:
            SubElement(SubElement(definitions, "SimpleType", name=name), "Real", facts)
        else:
            SubElement(definitions, "Float64Type", {"name": name, **facts})


def _numbers(variables: Sequence[FmuVariable], form: Form) -> dict[str, int]:
    """Name of each variable → the number by which it is referred to.

    In FMI 2.0 its place, from 1; in FMI 3.0 its value reference, which is its place from 0.
    """
    return {v.name: k for k, v in enumerate(variables, start=1 if form.is_2 else 0)}


def _add_variables(root: Element, variables: Sequence[FmuVariable], form: Form) -> None:
    number = _numbers(variables, form)
    if len(number) != len(variables):
        names = Counter(v.name for v in variables)
        raise ValueError(f"variables named twice: {sorted(n for n in names if names[n] > 1)}")
    count_of_type = Counter[str]()
    parent = SubElement(root, "ModelVariables")
    for reference, v in enumerate(variables):
        kind = v.type if v.type != "Real" else "Real" if form.is_2 else "Float64"
        named = _given(
            name=v.name,
            valueReference=str(count_of_type[kind] if form.is_2 else reference),
            description=_legal(v.description),
            causality=v.causality,
            variability=v.variability,
            initial=v.initial,
        )
        count_of_type[kind] += 1
        facts = {
            **(_quantity(v) if v.type == "Real" else {}),
            **_given(
                start=None if v.start is None else str(v.start),
                derivative=str(number[v.derivative_of]) if v.derivative_of else None,
            ),
        }
        if form.is_2:
            SubElement(SubElement(parent, "ScalarVariable", named), kind, facts)
            continue
        if v.variability == "continuous" and v.causality != "independent":
            named["intermediateUpdate"] = "true"
        SubElement(parent, kind, named | facts)


def _quantity(variable: FmuVariable) -> dict[str, str]:
    """Type, units, limits and nominal value of a Real.

    The unit stands here, too, for importers that do not look at types.
    """
    quantity = QUANTITIES.get(variable.unit)
    low, high, nominal = variable.minimum, variable.maximum, variable.nominal
    return _given(
        declaredType=quantity.type_name if quantity else None,
        unit=variable.unit,
        displayUnit=variable.display_unit or (quantity.shown if quantity else None),
        min=None if low == -math.inf else repr(low),
        max=None if high == math.inf else repr(high),
        nominal=None if nominal == 1.0 else repr(nominal),
    )


def _add_structure(
    root: Element, description: ModelDescription, variables: Sequence[FmuVariable], form: Form
) -> None:
    structure = SubElement(root, "ModelStructure")
    outputs, derivatives, at_start = form.unknowns
    names = () if form.exchange is None else description.derivatives
    by_name = {v.name: v for v in variables}
    rates = [by_name[name] for name in names]
    # at a communication point of co-simulation without model exchange only the inputs are known
    states = {rate.derivative_of for rate in rates}
    number = _numbers(variables, form)
    known = {
        v.name: number[v.name]
        for v in variables
        if v.causality in ("input", "independent") or v.name in states
    }
    text = {k: str(k) for k in number.values()}
    exact = {number[v.name] for v in variables if v.initial == "exact"}

    def unknowns(title: str, listed: Sequence[FmuVariable], *, initial: bool = False) -> None:
        parent = SubElement(structure, title) if form.is_2 and listed else structure
        tag, attribute = ("Unknown", "index") if form.is_2 else (title, "valueReference")
        everything = {*known.values(), *(exact if initial else ())}
        for v in listed:
            element = SubElement(parent, tag, {attribute: str(number[v.name])})
            needs, kinds = v.dependencies, v.kinds
            if initial:
                needs, kinds = v.initial_dependencies, v.initial_kinds
            if needs is None:
                continue
            numbers = number if initial else known
            pairs = zip(needs, kinds or [""] * len(needs), strict=True)
            found = dict(sorted((numbers[n], kind) for n, kind in pairs if n in numbers))
            long = form.is_2 and len(found) > LONG
            plain = long and {*found.values()} == {KINDS[-1]}
            if plain and everything <= found.keys():
                continue
            element.set("dependencies", " ".join([text[k] for k in found]))
            if kinds is not None and not plain:
                element.set("dependenciesKind", " ".join(found.values()))

    unknowns(outputs, [v for v in variables if v.causality == "output"])
    unknowns(derivatives, rates)
    asked = [
        v for v in variables if v.causality in ("output", "calculatedParameter") or v.name in names
    ]
    unknowns(at_start, [v for v in asked if v.initial != "exact"], initial=True)


def build_description_xml(model_identifier: str, sources: Sequence[str]) -> bytes:
    """The XML text (UTF-8) of `BUILD`: how a compiler makes the library of `sources`.

    Source: FMI Specification 3.0.2, section 2.4.10.
    """
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=model_identifier)
    files = SubElement(configuration, "SourceFileSet", language="C11")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    return _xml_bytes(root)
