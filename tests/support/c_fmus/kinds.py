"""The FMU of kinds.c, of FMI 1.0, 2.0 or 3.0: variables of all types."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import fmpy
from support.c_fmus.compiled import packed

HERE = Path(__file__).parent
ITEMS = {"off": 1, "slow": 2, "fast": 3}
WIDTHS = tuple(f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U"))
OPTIONS = {
    "through": "THROUGH",
    "clears": "CLEARS",
    "state": "STATE",
    "bytes": "BYTES",
    "events": "EVENTS",
}


@dataclass(frozen=True)
class K:
    """A variable: `kind` as FMI 2.0 calls it, in FMI 3.0 `wide`; `size` elements, 0: a scalar."""

    name: str
    reference: int
    kind: str
    causality: str
    start: str | None = None
    wide: str = ""
    size: int = 0

    @property
    def source(self) -> str:
        """The input that an output depends on, with the option `through`."""
        return "u" + self.name[1:]


COMMON = (
    K("period", 0, "Real", "parameter", "0"),
    K("u_real", 1, "Real", "input", "0"),
    K("y_real", 2, "Real", "output"),
    K("u_int", 3, "Integer", "input", "0", "Int32"),
    K("y_int", 4, "Integer", "output", None, "Int32"),
    K("u_bool", 5, "Boolean", "input", "false"),
    K("y_bool", 6, "Boolean", "output"),
    K("u_enum", 7, "Enumeration", "input", "1"),
    K("y_enum", 8, "Enumeration", "output"),
    K("u_text", 9, "String", "input", ""),
    K("y_text", 10, "String", "output"),
    K("offset", 11, "Integer", "parameter", "0", "Int32"),
)
TWICE = K("twice", 12, "Integer", "calculatedParameter", None, "Int32")
OF_FMI_3 = (
    *(
        K(f"{way}_{width.lower()}", 20 + 2 * k + (way == "y"), "Integer", causality, start, width)
        for k, width in enumerate(WIDTHS)
        for way, causality, start in (("u", "input", "0"), ("y", "output", None))
    ),
    K("u_list", 40, "Integer", "input", "0 0 0", "Int32", 3),
    K("y_list", 41, "Integer", "output", None, "Int32", 3),
    K("u_flags", 42, "Boolean", "input", "false false", size=2),
    K("y_flags", 43, "Boolean", "output", size=2),
    K("u_floats", 44, "Real", "input", "0 0", "Float32", 2),
    K("y_floats", 45, "Real", "output", None, "Float32", 2),
    K("u_words", 46, "String", "input", "", size=2),
    K("y_words", 47, "String", "output", size=2),
)
TYPES_2 = (
    '<TypeDefinitions><SimpleType name="Mode"><Enumeration>{}</Enumeration></SimpleType>'
    "</TypeDefinitions>"
)
TYPES_1 = (
    '<TypeDefinitions><Type name="Mode"><EnumerationType>{}</EnumerationType></Type>'
    "</TypeDefinitions>"
)
TYPES_3 = '<TypeDefinitions><EnumerationType name="Mode">{}</EnumerationType></TypeDefinitions>'


def build_kinds(version: int, options: Sequence[str], folder: Path) -> Path:
    """The FMU of FMI `version`, in `folder`."""
    name = "_".join(["kinds", *options, f"fmi{version}"])
    text = (describe_1, describe_2, describe_3)[version - 1](name, options)
    flags = [f"-D{OPTIONS[option]}" for option in options]
    sources = [HERE / "kinds.c", *([HERE / "absent_3.c"] if version == 3 else [])]
    command = ["-O1", f"-DVERSION={version}", f"-DIDENTIFIER={name}", *flags, *map(str, sources)]
    platform = fmpy.platform_tuple if version == 3 else fmpy.platform
    return packed(folder, name, text, [*command, "-lm"], platform)


def _items(*, numbered: bool) -> str:
    return "".join(
        f'<Item name="{name}"' + (f' value="{value}"' if numbered else "") + "/>"
        for name, value in ITEMS.items()
    )


def _typed(v: K) -> str:
    start = f' start="{v.start}"' if v.start is not None else ""
    declared = ' declaredType="Mode"' if v.kind == "Enumeration" else ""
    return f"<{v.kind}{start}{declared}/>"


def describe_1(name: str, options: Sequence[str]) -> str:
    lines = []
    for v in COMMON:
        causality, variability = v.causality, "continuous" if v.kind == "Real" else "discrete"
        if v.causality == "parameter":
            causality, variability = "internal", "parameter"
        needs = ""
        if v.causality == "output":
            direct = f"<Name>{v.source}</Name>" if _depends(v, options) else ""
            needs = f"<DirectDependency>{direct}</DirectDependency>"
        lines.append(
            f'<ScalarVariable name="{v.name}" valueReference="{v.reference}" '
            f'variability="{variability}" causality="{causality}">{_typed(v)}{needs}'
            "</ScalarVariable>"
        )
    return (
        '<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="1.0" '
        f'modelName="{name}" modelIdentifier="{name}" guid="{name}" numberOfContinuousStates="0" '
        f'numberOfEventIndicators="0">{TYPES_1.format(_items(numbered=False))}<ModelVariables>'
        f"{''.join(lines)}</ModelVariables><Implementation><CoSimulation_StandAlone><Capabilities "
        'canHandleVariableCommunicationStepSize="true"/></CoSimulation_StandAlone>'
        "</Implementation></fmiModelDescription>"
    )


def _depends(v: K, options: Sequence[str]) -> bool:
    return "through" in options and v.name != "y_real"


def describe_2(name: str, options: Sequence[str]) -> str:
    variables = (*COMMON, TWICE)
    index = {v.name: k for k, v in enumerate(variables, 1)}
    lines, outputs, initial = [], "", ""
    for v in variables:
        variability = "continuous" if v.kind == "Real" else "discrete"
        first = ' initial="calculated"'
        if v.causality in ("parameter", "calculatedParameter"):
            variability = "fixed"
        if v.causality in ("parameter", "input"):
            first = ' initial="exact"' if v.causality == "parameter" else ""
        lines.append(
            f'<ScalarVariable name="{v.name}" valueReference="{v.reference}" '
            f'causality="{v.causality}" variability="{variability}"{first}>{_typed(v)}'
            "</ScalarVariable>"
        )
        if v.causality == "output":
            now = f"{index[v.source]}" if _depends(v, options) else ""
            outputs += f'<Unknown index="{index[v.name]}" dependencies="{now}"/>'
            needs = now
            needs += f" {index['offset']}" if v.name == "y_int" else ""
            initial += f'<Unknown index="{index[v.name]}" dependencies="{needs}"/>'
    initial += f'<Unknown index="{index["twice"]}" dependencies="{index["offset"]}"/>'
    state = 'canGetAndSetFMUstate="true"' if "state" in options else ""
    state += ' canSerializeFMUstate="true"' if "bytes" in options else ""
    return (
        '<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="2.0" '
        f'modelName="{name}" guid="{name}"><CoSimulation modelIdentifier="{name}" '
        f'canHandleVariableCommunicationStepSize="true" {state}/>'
        f"{TYPES_2.format(_items(numbered=True))}<ModelVariables>{''.join(lines)}"
        f"</ModelVariables><ModelStructure><Outputs>{outputs}</Outputs><InitialUnknowns>{initial}"
        "</InitialUnknowns></ModelStructure></fmiModelDescription>"
    )


def describe_3(name: str, options: Sequence[str]) -> str:
    lines = (
        '<Float64 name="time" valueReference="999" causality="independent" '
        'variability="continuous"/>'
    )
    outputs = initial = ""
    for v in (*COMMON, TWICE, *OF_FMI_3):
        kind = v.wide or {"Real": "Float64"}.get(v.kind, v.kind)
        variability = "continuous" if v.kind == "Real" else "discrete"
        if v.causality in ("parameter", "calculatedParameter"):
            variability = "fixed"
        start = f' start="{v.start}"' if v.start is not None and v.kind != "String" else ""
        declared = ' declaredType="Mode"' if v.kind == "Enumeration" else ""
        inside = f'<Dimension start="{v.size}"/>' if v.size else ""
        if v.kind == "String" and v.start is not None:
            inside += '<Start value=""/>' * max(1, v.size)
        lines += (
            f'<{kind} name="{v.name}" valueReference="{v.reference}" causality="{v.causality}" '
            f'variability="{variability}"{start}{declared}>{inside}</{kind}>'
        )
        if v.causality == "output":
            now = v.reference - 1 if _depends(v, options) else ""
            outputs += f'<Output valueReference="{v.reference}" dependencies="{now}"/>'
            needs = f"{now} 11" if v.name == "y_int" else now
            initial += f'<InitialUnknown valueReference="{v.reference}" dependencies="{needs}"/>'
    initial += '<InitialUnknown valueReference="12" dependencies="11"/>'
    state = 'canGetAndSetFMUState="true"' if "state" in options else ""
    state += ' canSerializeFMUState="true"' if "bytes" in options else ""
    events = 'hasEventMode="true"' if "events" in options else ""
    return (
        '<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="3.0" '
        f'modelName="{name}" instantiationToken="{name}"><CoSimulation modelIdentifier="{name}" '
        f'canHandleVariableCommunicationStepSize="true" {state} {events}/>'
        f"{TYPES_3.format(_items(numbered=True))}<ModelVariables>{lines}</ModelVariables>"
        f"<ModelStructure>{outputs}{initial}</ModelStructure></fmiModelDescription>"
    )
