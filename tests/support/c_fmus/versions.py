"""Compiles C models into FMUs of FMI 1.0 and 3.0: those of `build`, and some of FMI 3.0 only."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import fmpy
from support.c_fmus.build import HERE, MODELS, OPTIONS, UNITS, V, armed
from support.c_fmus.compiled import packed

OPTIONS_1 = {
    "inputs": 'canInterpolateInputs="true"',
    "clears": "",
    "rounds": "",
    "lazy": "",
    "picky": "",
    "discrete": "",
    "armed": "",
}
OPTIONS_3 = {
    "state": 'canGetAndSetFMUState="true"',
    "bytes": 'canSerializeFMUState="true"',
    "forgets": "",
    "jacobian": 'providesDirectionalDerivatives="true"',
    "lazy": "",
    "picky": "",
    "loud": "",
    "events": 'hasEventMode="true" mightReturnEarlyFromDoStep="true"',
    "clears": "",
    "rounds": "",
    "tenth": 'fixedInternalStepSize="0.1"',
    "rigid": "",
    "discrete": "",
    "armed": "",
    "refuses": 'hasEventMode="true" mightReturnEarlyFromDoStep="true"',
}
FLAGS = {
    **{name: flag for name, (flag, _) in OPTIONS.items()},
    "events": "EVENTS",
    "tenth": "TENTH",
    "rigid": "RIGID",
    "refuses": "REFUSES",
}

TIME = (
    '<Float64 name="time" valueReference="999" causality="independent" variability="continuous"/>'
)
FIXED = 'causality="parameter" variability="fixed"'
EXACT = 'causality="output" initial="exact"'
BALL = f"""\
<Float64 name="gravity" valueReference="1" {FIXED} start="10"/>
<Float64 name="restitution" valueReference="2" {FIXED.replace("fixed", "tunable")} start="0.5"/>
<Float64 name="announces" valueReference="3" {FIXED} start="0"/>
<Float64 name="last" valueReference="4" {FIXED} start="1e9"/>
<Float64 name="kick" valueReference="5" causality="input" variability="discrete" start="0"/>
<Float64 name="push" valueReference="9" causality="input" start="0"/>
<Float64 name="h" valueReference="6" {EXACT} start="1"/>
<Float64 name="v" valueReference="7" {EXACT} derivative="6" start="0"/>
<Float64 name="hits" valueReference="8" {EXACT} variability="discrete" start="0"/>"""
BALL_OUTPUTS = "".join(f'<Output valueReference="{k}" dependencies=""/>' for k in (6, 7, 8))

_WHOLE = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Boolean")
GALLERY = "\n".join(
    [
        '<UInt64 name="size" valueReference="1" causality="structuralParameter" '
        'variability="fixed" start="3"/>',
        f'<Float64 name="gain" valueReference="2" {FIXED} start="1"/>',
        '<Float64 name="u" valueReference="3" causality="input" start="0.5">'
        '<Dimension valueReference="1"/></Float64>',
        '<Float64 name="y" valueReference="4" causality="output"><Dimension valueReference="1"/>'
        '<Alias name="response"/></Float64>',
        '<Float32 name="u32" valueReference="5" causality="input" start="0 0">'
        '<Dimension start="2"/></Float32>',
        '<Float32 name="y32" valueReference="6" causality="output">'
        '<Dimension start="2"/></Float32>',
        '<Float64 name="sum" valueReference="7" causality="output"/>',
        *(
            f'<{kind} name="{kind.lower()}" valueReference="{8 + k}" causality="parameter" '
            f'variability="fixed" start="{"false" if kind == "Boolean" else 0}"/>'
            for k, kind in enumerate(_WHOLE)
        ),
        '<String name="word" valueReference="17" causality="parameter" variability="fixed">'
        '<Start value=""/></String>',
        '<Binary name="bytes" valueReference="18" causality="parameter" variability="fixed">'
        '<Start value=""/></Binary>',
        '<Enumeration name="mode" valueReference="19" causality="parameter" variability="fixed" '
        'declaredType="Mode" start="1"/>',
        '<Binary name="echo" valueReference="20" causality="output" variability="discrete" '
        'initial="calculated"/>',
    ]
)
GALLERY_TYPES = (
    '<TypeDefinitions><EnumerationType name="Mode"><Item name="slow" value="1"/>'
    '<Item name="fast" value="2"/></EnumerationType></TypeDefinitions>'
)
GALLERY_OUTPUTS = (
    '<Output valueReference="4" dependencies="3"/><Output valueReference="6" dependencies="5"/>'
    '<Output valueReference="7" dependencies=""/><Output valueReference="20" dependencies=""/>'
    + "".join(f'<InitialUnknown valueReference="{k}"/>' for k in (4, 6, 7, 20))
)
SPECIAL = {"ball": (BALL, BALL_OUTPUTS, ""), "gallery": (GALLERY, GALLERY_OUTPUTS, GALLERY_TYPES)}
"""Of FMI 3.0 only: variables, structure, definitions."""


def build_version(version: str, name: str, folder: Path) -> Path:
    """The FMU ``model+option+option`` of FMI `version`, "1" or "3", in `folder`."""
    model, *options = name.split("+")
    name = "_".join([model, *options, f"fmi{version}"])
    if model in SPECIAL:
        sources, flags = [HERE / f"{model}_3.c", HERE / "absent_3.c"], []
        text = description_3(name, *SPECIAL[model], options)
    else:
        source, variables = MODELS[model]
        sources = (
            [HERE / "shell_1.c"] if version == "1" else [HERE / "shell_3.c", HERE / "absent_3.c"]
        )
        inputs_from = next((k for k, v in enumerate(variables) if v.causality == "input"), 0)
        flags = [f'-DMODEL="{source}"', f"-DIDENTIFIER={name}", f"-DINPUTS_FROM={inputs_from}"]
        text = (description_1 if version == "1" else scalars_3)(name, variables, options)
    flags += [f"-D{FLAGS[option]}" for option in options if FLAGS[option]]
    flags += armed(folder / name, options)
    platform = fmpy.platform if version == "1" else fmpy.platform_tuple
    return packed(folder, name, text, ["-O1", *flags, *map(str, sources), "-lm"], platform)


def description_1(name: str, variables: Sequence[V], options: Sequence[str] = ()) -> str:
    """The model description of FMI 1.0; value references count from 0."""
    units = "".join(f'<BaseUnit unit="{unit}"/>' for unit in UNITS)
    capabilities = " ".join(OPTIONS_1[option] for option in options)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f'<fmiModelDescription fmiVersion="1.0" modelName="{name}" modelIdentifier="{name}" '
        f'guid="{name}" numberOfContinuousStates="0" numberOfEventIndicators="0">'
        f"<UnitDefinitions>{units}</UnitDefinitions><ModelVariables>"
        + "".join(_scalar_1(k, v, options) for k, v in enumerate(variables))
        + "</ModelVariables><Implementation><CoSimulation_StandAlone><Capabilities "
        f'canHandleVariableCommunicationStepSize="true" {capabilities}/>'
        "</CoSimulation_StandAlone></Implementation></fmiModelDescription>"
    )


def _scalar_1(reference: int, v: V, options: Sequence[str]) -> str:
    fixed = v.causality == "parameter"
    discrete = v.causality == "output" and "discrete" in options
    variability = "parameter" if fixed else "discrete" if discrete else "continuous"
    causality = "internal" if fixed or v.causality == "calculatedParameter" else v.causality
    start = f' start="{v.start}"' if v.start is not None else ""
    needs = v.needs if v.causality == "output" else None
    declared = "" if needs is None else "".join(f"<Name>{n}</Name>" for n in needs)
    return (
        f'<ScalarVariable name={quoteattr(v.name)} valueReference="{reference}" '
        f'variability="{variability}" causality="{causality}">'
        f"<Real unit={quoteattr(v.unit)}{start}/>"
        + ("" if needs is None else f"<DirectDependency>{declared}</DirectDependency>")
        + "</ScalarVariable>"
    )


def scalars_3(name: str, variables: Sequence[V], options: Sequence[str] = ()) -> str:
    """The model description of FMI 3.0 of a model with scalars only, as that of FMI 2.0."""
    reference = {v.name: str(k) for k, v in enumerate(variables)}

    def needs(v: V) -> str:
        if v.needs is None:
            return ""
        return f' dependencies="{" ".join(reference[name] for name in v.needs)}"'

    lines = []
    for v in variables:
        fixed = v.causality in ("parameter", "calculatedParameter")
        parts = [f"name={quoteattr(v.name)}", f'valueReference="{reference[v.name]}"']
        parts += [f'causality="{v.causality}"', f"unit={quoteattr(v.unit)}"]
        parts += ['variability="tunable"' if v.tunable else 'variability="fixed"'] if fixed else []
        if v.causality == "output" and "discrete" in options:
            parts += ['variability="discrete"']
        parts += [f'initial="{v.initial}"'] if v.initial else []
        parts += [f'start="{v.start}"'] if v.start is not None else []
        parts += [f'derivative="{reference[v.rate_of]}"'] if v.rate_of else []
        lines.append(f"<Float64 {' '.join(parts)}/>")
    told = [v for v in variables if v.causality == "output"]
    initial = [v for v in variables if v.causality in ("output", "calculatedParameter")]
    structure = "".join(f'<Output valueReference="{reference[v.name]}"{needs(v)}/>' for v in told)
    structure += "".join(
        f'<InitialUnknown valueReference="{reference[v.name]}"{needs(v)}/>'
        for v in initial
        if v.initial != "exact"
    )
    units = "".join(f'<Unit name="{u}"><BaseUnit {e}/></Unit>' for u, e in UNITS.items())
    units = f"<UnitDefinitions>{units}</UnitDefinitions>"
    return description_3(name, "".join(lines), structure, units, options)


def description_3(
    name: str, variables: str, structure: str, definitions: str, options: Sequence[str]
) -> str:
    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f'<fmiModelDescription fmiVersion="3.0" modelName="{name}" instantiationToken="{name}">'
        f'<CoSimulation modelIdentifier="{name}" '
        f'canHandleVariableCommunicationStepSize="{str("rigid" not in options).lower()}" '
        + " ".join(OPTIONS_3[option] for option in options)
        + f"/>{definitions}<ModelVariables>{TIME}{variables}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
