"""An FMU without a fault, and the same FMU with one fault each: what a validation has to find."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

from support.c_fmus.compiled import packed

HERE = Path(__file__).parent / "c_fmus"
NAME = "oscillator"
XML = "modelDescription.xml"


@dataclass(frozen=True)
class Defect:
    """A fault: the macro that plants it into the C code, or a change of the description's text.

    `expected` are the ids of all errors and warnings that it leads to.
    """

    expected: frozenset[str]
    macro: str = ""
    change: tuple[str, str] = ("", "")
    text_only: bool = False
    """Nothing that is called depends on it."""


def _code(macro: str, *expected: str) -> Defect:
    return Defect(frozenset(expected), macro=macro)


def _text(old: str, new: str, *expected: str) -> Defect:
    return Defect(frozenset(expected), change=(old, new))


def _inert(old: str, new: str, *expected: str) -> Defect:
    return Defect(frozenset(expected), change=(old, new), text_only=True)


DEFECTS: dict[str, Defect] = {
    # ---- the library ----
    "one variable is not in the saved state": _code(
        "STATE_HIDDEN",
        "state.rollback",
        "state.serialised",
        "state_elsewhere.differs",
    ),
    "saving disturbs": _code("STATE_DISTURBS", "state.disturbs"),
    "states are declared, but refused": _code("NO_STATE", "capabilities.missing"),
    "another version is answered": _code("VERSION", "start.version"),
    "no version is answered": _code("NO_VERSION", "start.version"),
    "reset crashes": _code("RESET_CRASHES", "instances.crash"),
    "reset hangs": _code("RESET_HANGS", "instances.hang"),
    "reset forgets a state": _code("RESET", "instances.reset"),
    "instances share a state": _code("SHARED", "instances.shared"),
    "directional derivative of the wrong sign": _code("DIRECTIONAL_SIGN", "directional.mismatch"),
    "one entry of the directional derivatives": _code("DIRECTIONAL_ENTRY", "directional.mismatch"),
    "a function is not exported": _code("NO_EXPORT", "start.library"),
    # ---- the description ----
    "a dependency is missing": _text(
        'index="9" dependencies="5 7" dependenciesKind="dependent dependent"',
        'index="9" dependencies="7" dependenciesKind="dependent"',
        "dependencies.missing",
    ),
    "an output that is a state declares no dependency": _text(
        'index="6" dependencies="6" dependenciesKind="constant"', 'index="6" dependencies=""'
    ),
    "derivative of another variable": _text('derivative="12"', 'derivative="10"', "start.order"),
    "a unit is missing": _inert('unit="m/s" ', "", "units.derivative_missing"),
    "the unit of a derivative": _inert('unit="m/s2"', 'unit="m/s"', "units.derivative"),
    "the exponents of a unit": _inert(
        'kg="1" m="2" s="-3"', 'kg="1" m="3" s="-3"', "units.definition"
    ),
    "a unit that is not defined": _inert('unit="W"', 'unit="kW"', "description.invalid"),
    "a stale GUID": _text('guid="oscillator"', 'guid="pendulum"', "start.refused"),
    "another start of a parameter": _text('start="5.0"', 'start="5.1"', "start.values"),
    "another start of a state": _text('start="0.4"', 'start="-0.4"', "start.values"),
    "a start that is not finite": _text('start="5.0"', 'start="INF"', "variables.start"),
    "start below min": _inert('start="5.0"', 'min="6.0" start="5.0"', "variables.start"),
    "min above max": _inert('start="5.0"', 'min="6.0" max="4.0" start="5.0"', "variables.limits"),
    "nominal below zero": _inert('start="0.4"', 'nominal="-1.0" start="0.4"', "variables.nominal"),
    "an output that is not in ModelStructure": _text(
        '<Unknown index="10" dependencies="5 6" dependenciesKind="constant tunable"/>',
        "",
        "description.invalid",
    ),
    "two parameters of one value reference": _text(
        'name="damping" valueReference="1"',
        'name="damping" valueReference="0"',
        "variables.alias",
        "start.values",
        "dependencies.missing",
        "directional.mismatch",
    ),
    "a library of another name": _inert(
        'modelIdentifier="oscillator"', 'modelIdentifier="pendulum"', "library.missing"
    ),
}

_ABILITIES = (
    f'modelIdentifier="{NAME}" canGetAndSetFMUstate="true" canSerializeFMUstate="true" '
    'providesDirectionalDerivative="true"'
)
_UNITS = {
    "kg": 'kg="1"',
    "N": 'kg="1" m="1" s="-2"',
    "N.s/m": 'kg="1" s="-1"',
    "N/m": 'kg="1" s="-2"',
    "N/s": 'kg="1" m="1" s="-3"',
    "1/s2": 's="-2"',
    "m": 'm="1"',
    "m/s": 'm="1" s="-1"',
    "m/s2": 'm="1" s="-2"',
    "W": 'kg="1" m="2" s="-3"',
}
# name, causality, variability, initial, unit, start, place of what it is the derivative of
_VARIABLES = (
    ("mass", "parameter", "fixed", "exact", "kg", 2.0, None),
    ("damping", "parameter", "fixed", "exact", "N.s/m", 0.3, None),
    ("stiffness", "parameter", "tunable", "exact", "N/m", 5.0, None),
    ("ratio", "calculatedParameter", "tunable", "calculated", "1/s2", None, None),
    ("force", "input", "continuous", None, "N", 0.5, None),
    ("x", "output", "continuous", "exact", "m", 0.4, None),
    ("v", "output", "continuous", "exact", "m/s", 0.0, 6),
    ("a", "output", "continuous", "calculated", "m/s2", None, 7),
    ("power", "output", "continuous", "calculated", "W", None, None),
    ("load", "output", "continuous", "calculated", "N", None, None),
    ("stretch", "local", "continuous", "calculated", "m", None, None),
    ("filtered", "local", "continuous", "exact", "N", 0.1, None),
    ("rate", "local", "continuous", "calculated", "N/s", None, 12),
)
_STRUCTURE = """
<Outputs>
<Unknown index="6" dependencies="6" dependenciesKind="constant"/>
<Unknown index="7" dependencies="7" dependenciesKind="constant"/>
<Unknown index="8" dependencies="6 7 12" dependenciesKind="dependent fixed fixed"/>
<Unknown index="9" dependencies="5 7" dependenciesKind="dependent dependent"/>
<Unknown index="10" dependencies="5 6" dependenciesKind="constant tunable"/>
</Outputs>
<Derivatives>
<Unknown index="7" dependencies="7" dependenciesKind="constant"/>
<Unknown index="8" dependencies="6 7 12" dependenciesKind="dependent fixed fixed"/>
<Unknown index="13" dependencies="5 12" dependenciesKind="constant constant"/>
</Derivatives>
<InitialUnknowns>
<Unknown index="4" dependencies="1 3"/>
<Unknown index="8" dependencies="1 2 3 6 7 12"/>
<Unknown index="9" dependencies="5 7"/>
<Unknown index="10" dependencies="3 5 6"/>
<Unknown index="13" dependencies="5 12"/>
</InitialUnknowns>
"""


def description() -> str:
    """The model description of the FMU without a fault."""
    units = "".join(f'<Unit name="{u}"><BaseUnit {e}/></Unit>' for u, e in _UNITS.items())
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="2.0" modelName="{NAME}" guid="{NAME}" '
        'numberOfEventIndicators="0">'
        f"<ModelExchange {_ABILITIES}/>"
        f'<CoSimulation {_ABILITIES} canHandleVariableCommunicationStepSize="true" '
        'canInterpolateInputs="true" maxOutputDerivativeOrder="1"/>'
        f"<UnitDefinitions>{units}</UnitDefinitions>"
        '<DefaultExperiment startTime="0.0" stopTime="10.0" stepSize="0.01"/>'
        f"<ModelVariables>{''.join(_scalar(k) for k in range(len(_VARIABLES)))}</ModelVariables>"
        f"<ModelStructure>{_STRUCTURE}</ModelStructure></fmiModelDescription>"
    )


def _scalar(reference: int) -> str:
    name, causality, variability, initial, unit, start, rate_of = _VARIABLES[reference]
    real = f'unit="{unit}" ' + (f'start="{start}" ' if start is not None else "")
    real += f'derivative="{rate_of}"' if rate_of else ""
    first = f' initial="{initial}"' if initial else ""
    return (
        f'<ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}" '
        f'variability="{variability}"{first}><Real {real}/></ScalarVariable>'
    )


def build(folder: Path, defect: Defect | None = None) -> Path:
    """The FMU with `defect`, or without a fault, in `folder`."""
    text = description()
    if defect and defect.change[0]:
        assert defect.change[0] in text
        text = text.replace(*defect.change)
    flags = [f"-DDEFECT_{defect.macro}"] if defect and defect.macro else []
    return packed(folder, NAME, text, ["-O0", *flags, str(HERE / "oscillator.c"), "-lm"])


def planted(path: Path, changed: Path, old: bytes, new: bytes, member: str = XML) -> Path:
    """The FMU at `path`, saved as `changed`, with other bytes in one of its files."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(changed, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            if name == member:
                assert old in content
                content = content.replace(old, new)
            target.writestr(name, content)
    return changed
