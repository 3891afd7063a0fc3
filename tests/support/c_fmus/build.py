"""Compiles the C models beside this file into FMI 2.0 FMUs and describes their variables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.sax.saxutils import quoteattr

from support.c_fmus.compiled import packed

HERE = Path(__file__).parent
UNITS = {
    "1": "",
    "1/s": 's="-1"',
    "m": 'm="1"',
    "mm": 'm="1" factor="0.001"',
    "m/s": 'm="1" s="-1"',
    "m/s2": 'm="1" s="-2"',
    "mm/s": 'm="1" s="-1" factor="0.001"',
    "mm/s2": 'm="1" s="-2" factor="0.001"',
    "s": 's="1"',
    "kg": 'kg="1"',
    "N": 'kg="1" m="1" s="-2"',
    "N/m": 'kg="1" s="-2"',
    "N/m3": 'kg="1" m="-2" s="-2"',
    "s/m": 's="1" m="-1"',
    "N.s/m": 'kg="1" s="-1"',
}


@dataclass(frozen=True)
class V:
    """A variable: `needs` are the names an output depends on, None if it declares nothing."""

    name: str
    unit: str
    causality: str
    start: float | None = None
    needs: tuple[str, ...] | None = ()
    rate_of: str | None = None
    initial: str | None = None
    tunable: bool = False


def parameter(name: str, unit: str, start: float, *, tunable: bool = False) -> V:
    return V(name, unit, "parameter", start, tunable=tunable)


def motion(prefix: str, *, acceleration_needs: tuple[str, ...] = ()) -> tuple[V, V, V]:
    """Outputs x, vx, ax; x and vx are states with a start value."""
    return (
        V(f"{prefix}x", "m", "output", 0.0, initial="exact"),
        V(f"{prefix}vx", "m/s", "output", 0.0, rate_of=f"{prefix}x", initial="exact"),
        V(f"{prefix}ax", "m/s2", "output", needs=acceleration_needs, rate_of=f"{prefix}vx"),
    )


def end(*, moves: bool) -> tuple[V, V]:
    """Inputs x, vx of an end; with `moves`, vx is declared as derivative of x."""
    return (
        V("end.x", "m", "input", 0.0),
        V("end.vx", "m/s", "input", 0.0, rate_of="end.x" if moves else None),
    )


STIFFNESS = parameter("stiffness", "N/m", 1.0)
DAMPING = parameter("damping", "N.s/m", 0.0, tunable=True)
END = ("end.x", "end.vx")

MASS = (
    parameter("mass", "kg", 1.0),
    parameter("stiffness", "N/m", 0.0),
    DAMPING,
    V("body.m.force_x", "N", "input", 0.0),
    *motion("body.m.", acceleration_needs=("body.m.force_x",)),
)
MM_MASS = (
    *MASS[:4],
    V("body.m.x", "mm", "output", 0.0, initial="exact"),
    V("body.m.vx", "mm/s", "output", 0.0, rate_of="body.m.x", initial="exact"),
    V("body.m.ax", "mm/s2", "output", needs=("body.m.force_x",), rate_of="body.m.vx"),
)
"""With a mass of 0.001 it weighs 1 kg, with a stiffness of 0.001 it is held by 1 N/m."""
PARTNER = (
    parameter("mass", "kg", 1.0),
    STIFFNESS,
    parameter("coupling", "N/m", 1.0),
    DAMPING,
    parameter("wall_damping", "N.s/m", 0.0),
    *end(moves=False),
    V("end.force_x", "N", "output", needs=END),
    V("x", "m", "output", 0.0, initial="exact"),
    V("vx", "m/s", "output", 0.0, rate_of="x", initial="exact"),
)
MIDDLE = (
    *PARTNER[:7],
    V("body.m.force_x", "N", "input", 0.0),
    V("end.force_x", "N", "output", needs=END),
    *motion("body.m.", acceleration_needs=(*END, "body.m.force_x")),
)
MEMBER = (
    parameter("mass", "kg", 1.0),
    STIFFNESS,
    parameter("cubic", "N/m3", 0.0),
    parameter("wall_damping", "N.s/m", 0.0),
    parameter("coupling", "N/m", 0.0),
    parameter("coupling_cubic", "N/m3", 0.0),
    parameter("damping", "N.s/m", 0.0),
    parameter("stop", "m", 0.0),
    parameter("stop_side", "1", 1.0),
    parameter("stop_stiffness", "N/m", 0.0),
    parameter("stop_damping", "s/m", 0.0),
    parameter("between", "1", 0.0),
    parameter("armed", "s", 1e9),
    parameter("switched", "s", 1e9),
    parameter("switch_factor", "1", 0.0),
    parameter("burst", "s", 1e9),
    parameter("burst_width", "s", 1.0),
    parameter("burst_force", "N", 0.0),
    parameter("inside", "s", 1e-3),
    *end(moves=False),
    V("body.m.force_x", "N", "input", 0.0),
    V("end.force_x", "N", "output", needs=END),
    *motion("body.m.", acceleration_needs=(*END, "body.m.force_x")),
)
MOVING_PARTNER = (*PARTNER[:5], *end(moves=True), *PARTNER[7:])
SPRING = (STIFFNESS, DAMPING, *end(moves=False), V("end.force_x", "N", "output", needs=END))
BARE_SPRING = tuple(replace(v, unit="") for v in SPRING)
BLIND_SPRING = (*SPRING[:-1], V("end.force_x", "N", "output", needs=None))
"""Declares no dependencies, as the FMUs of some tools."""
BLIND_MASS = (*MASS[:4], *(replace(v, needs=None) for v in MASS[4:]))
ADDED_MASS = (
    parameter("added", "kg", 0.0),
    STIFFNESS,
    V("end.x", "m", "input", 0.0),
    V("end.ax", "m/s2", "input", 0.0),
    V("end.force_x", "N", "output", needs=("end.x", "end.ax")),
)
BLIND_ADDED_MASS = (*ADDED_MASS[:-1], replace(ADDED_MASS[-1], needs=None))
LATE_ADDED_MASS = (*ADDED_MASS[:-1], V("end.force_x", "N", "output", needs=()))
"""Declares that its force does not follow the acceleration at once, and so is a step late."""
FUSE = (STIFFNESS, parameter("limit", "m", 1e6), *end(moves=False), SPRING[-1])
PLAIN_MASS = tuple(replace(v, rate_of=None) for v in MASS)
PLAIN_PARTNER = tuple(replace(v, rate_of=None) for v in PARTNER)
"""Without declared derivatives, as the FMUs of many tools."""
VAN_DER_POL = (
    parameter("mu", "1", 2.0),
    V("u", "1", "input", 0.0),
    V("x", "1", "output", 1e-9, initial="exact"),
    V("dx", "1/s", "output", 0.0, rate_of="x", initial="exact"),
)
MM_SPRING = (STIFFNESS, DAMPING, V("end.x", "mm", "input", 0.0), *SPRING[3:])
DAMPER = (
    parameter("stiffness", "N/m", 0.0),
    DAMPING,
    parameter("x", "m", 0.0),
    V("end.vx", "m/s", "input", 0.0),
    V("end.force_x", "N", "output", needs=("end.vx",)),
)
LINE = (STIFFNESS, DAMPING, *end(moves=True), V("end.force_x", "N", "output", needs=()))
STAGE = (
    parameter("gain", "1", 1.0),
    V("twice", "1", "calculatedParameter", needs=("gain",)),
    V("u", "s", "input", 0.0),
    V("y", "s", "output", needs=("u",)),
)
BLIND_STAGE = (*STAGE[:-1], V("y", "s", "output", needs=None))
LATCH = (
    parameter("when", "s", 0.5),
    V("u", "1", "input", 0.0),
    V("y", "1", "output", needs=None),
)
INTEGRATOR = (
    parameter("gain", "1/s", 1.0),
    V("u", "1", "input", 0.0),
    V("y", "1", "output", 0.0, initial="exact"),
)
EULER = (
    parameter("rate", "1/s", 1.0),
    V("u", "1", "input", 0.0),
    V("y", "1", "output", 0.0, initial="exact"),
)
BLIND_INTEGRATOR = (*INTEGRATOR[:-1], V("y", "1", "output", 0.0, needs=None, initial="exact"))
LAG = (V("u", "1", "input", 0.0), V("y", "1", "output", 0.0, initial="exact"))
PI = (
    V("y", "1", "input", 0.0),
    V("integral", "s", "output", 0.0, initial="exact"),
    V("u", "1", "output", needs=("y",)),
)
ROESSLER_X = (
    V("y", "1", "input", 0.0),
    V("z", "1", "input", 0.0),
    V("x", "1", "output", 0.0, initial="exact"),
)
ROESSLER_YZ = (
    V("x", "1", "input", 0.0),
    V("y", "1", "output", 0.0, initial="exact"),
    V("z", "1", "output", 0.0, initial="exact"),
)
SWITCH = (parameter("when", "s", 1.0), V("y", "1", "output", 0.0, initial="exact"))
SLEEPER = (
    parameter("gain", "1", 0.0),
    parameter("when", "s", 2.0),
    V("u", "1", "input", 0.0),
    V("y", "1", "output", needs=("u",)),
    V("z", "1", "output", needs=("u",)),
)
FREE_SLEEPER = (*SLEEPER[:-2], *(replace(v, needs=()) for v in SLEEPER[-2:]))
BLIND_SLEEPER = (*SLEEPER[:-2], *(replace(v, needs=None) for v in SLEEPER[-2:]))
RELAY = (
    parameter("low", "1", -0.5),
    parameter("high", "1", 0.5),
    V("u", "1", "input", 0.0),
    V("y", "1", "output", 1.0, initial="exact"),
)
NODE = (
    *(V(f"u{k}", "1", "input", 0.0) for k in range(3)),
    *(V(f"y{k}", "1", "output", 0.0, initial="exact") for k in range(3)),
)
WIDE = (
    *(V(f"u{k}", "1", "input", 0.0) for k in range(10)),
    *(V(f"y{k}", "1", "output", 0.0, initial="exact") for k in range(10)),
)
ENDING = (
    parameter("when", "s", 1.0),
    V("u", "1", "input", 0.0),
    V("y", "s", "output", 0.0, initial="exact"),
)
KEEPER = (parameter("gain", "1/s", 1.0), V("u", "1", "input", 0.0), V("y", "1", "output"))
ROGUE = (parameter("what", "1", 0.0), parameter("when", "s", 1.0), V("y", "s", "output"))
VANDAL = (*ROGUE[:2], parameter("pause", "s", 0.0), ROGUE[2])
TALKER = (
    parameter("logged", "1", 1.0),
    parameter("answer", "1", 0.0),
    parameter("count", "1", 1.0),
    parameter("kinds", "1", 1.0),
    parameter("when", "s", 0.0),
    V("y", "s", "output"),
)

MODELS: dict[str, tuple[str, tuple[V, ...]]] = {
    "mass": ("mass.c", MASS),
    "plain_mass": ("mass.c", PLAIN_MASS),
    "plain_partner": ("partner.c", PLAIN_PARTNER),
    "mm_mass": ("mass.c", MM_MASS),
    "partner": ("partner.c", PARTNER),
    "middle": ("middle.c", MIDDLE),
    "member": ("member.c", MEMBER),
    "moving_partner": ("partner.c", MOVING_PARTNER),
    "spring": ("spring.c", SPRING),
    "bare_spring": ("spring.c", BARE_SPRING),
    "blind_spring": ("spring.c", BLIND_SPRING),
    "damper": ("spring.c", DAMPER),
    "late_added_mass": ("added_mass.c", LATE_ADDED_MASS),
    "fuse": ("fuse.c", FUSE),
    "van_der_pol": ("van_der_pol.c", VAN_DER_POL),
    "mm_spring": ("spring.c", MM_SPRING),
    "added_mass": ("added_mass.c", ADDED_MASS),
    "line": ("line.c", LINE),
    "stage": ("stage.c", STAGE),
    "blind_stage": ("stage.c", BLIND_STAGE),
    "latch": ("latch.c", LATCH),
    "blind_mass": ("mass.c", BLIND_MASS),
    "blind_added_mass": ("added_mass.c", BLIND_ADDED_MASS),
    "integrator": ("integrator.c", INTEGRATOR),
    "euler": ("euler.c", EULER),
    "blind_integrator": ("integrator.c", BLIND_INTEGRATOR),
    "lag": ("lag.c", LAG),
    "pi": ("pi.c", PI),
    "roessler_x": ("roessler_x.c", ROESSLER_X),
    "roessler_yz": ("roessler_yz.c", ROESSLER_YZ),
    "switch": ("switch.c", SWITCH),
    "sleeper": ("sleeper.c", SLEEPER),
    "free_sleeper": ("sleeper.c", FREE_SLEEPER),
    "blind_sleeper": ("sleeper.c", BLIND_SLEEPER),
    "relay": ("relay.c", RELAY),
    "node": ("node.c", NODE),
    "ending": ("ending.c", ENDING),
    "wide": ("wide.c", WIDE),
    "busy": ("busy.c", (parameter("work", "s", 0.0), V("y", "s", "output"))),
    "keeper": ("keeper.c", KEEPER),
    "rogue": ("rogue.c", ROGUE),
    "talker": ("talker.c", TALKER),
    "vandal": ("vandal.c", VANDAL),
}


OPTIONS = {
    "state": ("STATE", 'canGetAndSetFMUstate="true"'),
    "bytes": ("BYTES", 'canSerializeFMUstate="true"'),
    "unreadable": ("UNREADABLE", ""),
    "forgets": ("FORGETS", ""),
    "claims": ("CLAIMS", 'canGetAndSetFMUstate="true"'),
    "inputs": ("INPUTS", 'canInterpolateInputs="true"'),
    "single": ("SINGLE", ""),
    "first": ("LIMIT=1", ""),
    "none": ("LIMIT=0", ""),
    "ignored": ("IGNORED=2", ""),
    "jacobian": ("JACOBIAN", 'providesDirectionalDerivative="true"'),
    "once": ("ONCE", 'canBeInstantiatedOnlyOncePerProcess="true"'),
    "alone": ("ALONE", 'canBeInstantiatedOnlyOncePerProcess="true"'),
    "constant": ("CONSTANT", 'canHandleVariableCommunicationStepSize="false"'),
    "hundredth": ("OWN_STEP=0.01", ""),
    "fiftieth": ("OWN_STEP=0.02", ""),
    "strict": ("STRICT", ""),
    "clears": ("CLEARS", ""),
    "partly": ("PARTLY", ""),
    "nans": ("NANS", ""),
    "noisy": ("NOISY", ""),
    "refreshes": ("REFRESHES", ""),
    "rounds": ("ROUNDS", ""),
    "lazy": ("LAZY", ""),
    "picky": ("PICKY", ""),
    "loud": ("LOUD", ""),
    "discrete": ("", ""),
    "anonymous": ("ANONYMOUS", ""),
    "reluctant": ("RELUCTANT", ""),
    "armed": ("", ""),
}
"""Capabilities that an FMU may have or lack: compiler flag and attribute of the description.

A constant one refuses steps of another size than its first, one of a hundredth all but 0.01 s, one
of a fiftieth all but 0.02 s. A strict one makes no step beyond the stop time. One that clears shows
zeros when something has been set, until it has made a step, partly: but for its gain; one with nans
shows these instead. A noisy one never gives its y twice to the bit. One of which second derivatives
are ignored answers them with a warning. One that
refreshes shows what a step has made when something has been set. A loud one warns with its name
when it is initialised, an anonymous one without saying which instance it is. One that rounds leaves
its steps with rounding upward. A reluctant one answers its end with an error. One with a state as
bytes can give it to another process; an unreadable one crashes when it is to take one. One with a
state that forgets does not bring its last variable back; one that claims has no state. One that is
discrete declares its outputs so. An armed one does harm when the file `trouble_file` says so: see
trouble.h.
"""


def build(name: str, folder: Path, linked: Sequence[str] = ()) -> Path:
    """The FMU ``model`` or ``model+option+option`` of MODELS and OPTIONS, in `folder`.

    `linked` are further options for the linker.
    """
    model, *options = name.split("+")
    source, variables = MODELS[model]
    name = "_".join([model, *options])
    flags = ["-DMOVES"] if model == "moving_partner" else []
    flags += [f"-D{OPTIONS[option][0]}" for option in options if OPTIONS[option][0]]
    flags += [*armed(folder / name, options), str(HERE / "shell.c"), "-lm", *linked]
    text = describe(name, variables, options)
    return packed(folder, name, text, ["-O1", f'-DMODEL="{source}"', *flags])


def armed(fmu: Path, options: Sequence[str]) -> list[str]:
    """The compiler's flag of an armed FMU."""
    return [f'-DARMED="{trouble_file(fmu)}"'] if "armed" in options else []


def trouble_file(fmu: Path) -> Path:
    """The file that arms an FMU: a line of call, fault and time [s]."""
    return fmu.with_suffix(".trouble")


def describe(name: str, variables: tuple[V, ...], options: Sequence[str] = ()) -> str:
    """The model description; value references count from 0 in the order of the variables."""
    index = {v.name: str(k) for k, v in enumerate(variables, 1)}
    units = "".join(f'<Unit name="{u}"><BaseUnit {e}/></Unit>' for u, e in UNITS.items())
    outputs = [v for v in variables if v.causality == "output"]
    calculated = [v for v in variables if v.causality == "calculatedParameter"]
    unknowns = [v for v in (*outputs, *calculated) if v.initial != "exact"]

    def listed(vs: list[V]) -> str:
        return "".join(f'<Unknown index="{index[v.name]}"{_needs(v, index)}/>' for v in vs)

    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f'<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{name}">'
        f'<CoSimulation modelIdentifier="{name}" {_abilities(options)}/>'
        f"<UnitDefinitions>{units}</UnitDefinitions><ModelVariables>"
        + "".join(_scalar(k, v, index, options) for k, v in enumerate(variables))
        + f"</ModelVariables><ModelStructure><Outputs>{listed(outputs)}</Outputs>"
        + (f"<InitialUnknowns>{listed(unknowns)}</InitialUnknowns>" if unknowns else "")
        + "</ModelStructure></fmiModelDescription>"
    )


def _abilities(options: Sequence[str]) -> str:
    found = [OPTIONS[option][1] for option in options]
    if "constant" not in options:
        found.append('canHandleVariableCommunicationStepSize="true"')
    return " ".join(found)


def _needs(v: V, index: dict[str, str]) -> str:
    if v.needs is None:
        return ""
    return f' dependencies="{" ".join(index[name] for name in v.needs)}"'


def _scalar(reference: int, v: V, index: dict[str, str], options: Sequence[str]) -> str:
    fixed = v.causality in ("parameter", "calculatedParameter")
    variability = "tunable" if v.tunable else "fixed" if fixed else "continuous"
    if v.causality == "output" and "discrete" in options:
        variability = "discrete"
    initial = v.initial or {"parameter": "exact", "input": None}.get(v.causality, "calculated")
    real = f"unit={quoteattr(v.unit)}" if v.unit else ""
    if v.start is not None:
        real += f' start="{v.start}"'
    if v.rate_of:
        real += f' derivative="{index[v.rate_of]}"'
    return (
        f'<ScalarVariable name={quoteattr(v.name)} valueReference="{reference}" '
        f'description={quoteattr(f"{v.causality} {v.name}")} causality="{v.causality}" '
        f'variability="{variability}"'
        + (f' initial="{initial}"' if initial else "")
        + f"><Real {real}/></ScalarVariable>"
    )
