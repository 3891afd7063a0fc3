"""docs/benchmark.md and docs/benchmark.png from what `run` measured."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmark.aims import aims
from benchmark.figure import draw

Rows = Iterable[Sequence[str]]

_HEAD = """# Benchmark

Written by `make bench` on {when}. Everything below was measured in one run on one machine: CPU
time, one thread, the minimum over many short batches, the engines taking turns. Before anything is
timed, every engine must give the accelerations of a random state of the same system to 1e-9, or to
1e-6 beyond 100 links.

The system is the n-link planar pendulum of Sabet and Diaz-Flores Caminero, table 5: links of 2 m
and 10 kg, J = m L²/12, horizontal and at rest, g = 9.81 m/s². Trust ratios, not seconds.

All figures here are of planar chains. In space the factors are smaller: one right-hand side of an
arm of seven revolute joints takes 0.9 of Pinocchio's time interpreted and 0.48 compiled, one of a
chain of 60 ball joints 0.63 interpreted (it is too large to be compiled); an ensemble of the arm,
compiled, makes 7.2 times as many RK4 steps a second and core as MuJoCo. Measured on 2026-11-28 by
`python -m benchmark.space`, on this processor beside other work, the engines taking turns.

| | |
|---|---|
{machine}
"""

_RIGHT_HAND_SIDE = """
## Right-hand side

Time of one evaluation of the accelerations [µs]. Engines with a C interface are called from C,
without Python in between; a call of CasADi's buffered functions that does nothing is taken off.
PyDy, SymPy and pyM4E are called from Python, as they are used.

{table}

The same over the time of Pinocchio's articulated-body algorithm (below 1 is faster):

{ratios}

![Time of one right-hand side over the number of links](benchmark.png)

A random tree of 30 bodies, a fifth of the joints prismatic, with springs and dampers between points
and in joints. Pinocchio has no springs: their forces are computed in C++ from its kinematics.

{tree}
"""

_SPIDERFLOAT = """
SpiderFLOAT (the paper's section 4.2.3: a float, two arms, two sliders, two buoys, 14 springs and
dampers; forces held at their amplitude): milliseconds of CPU time from the model to something that
runs, microseconds of a right-hand side, seconds of 10 s by RK45 at 1e-8.

{table}
"""

_REST = """
## Integration

30 s, rtol = atol = 1e-8, results every 0.01 s. *Same integrator* is our C integrator with the
peer's accelerations in place of ours. Drift is the change of energy over the energy of the fall
from horizontal to hanging.

{integration}

## From a model to something that runs

CPU seconds from the elements of the model in Python.

{preparation}

## Derivatives, n = {middle}

The full Jacobian is that of the accelerations by coordinates and velocities, the right-hand side
included.

{derivatives}

## Ensemble, n = {middle}

CPU seconds per model for 1 s of simulated time, RK45.

{ensemble}

## Accuracy, n = {middle}

Largest error of an acceleration over the largest acceleration, in a random state, against the dense
equations solved with 50 digits.

{accuracy}

## Whole process and memory, n = {middle}

{process}

## Steps of FMUs

The pendulum of ten links as co-simulation FMUs, H = 1 ms: CPU time of `doStep`, from Python with
arguments prepared once and from C. The lambdified FMU is SymPy's Kane equations for NumPy in a
Python FMU, with classical Runge-Kutta steps, stepped by FMPy.

{steps}

An export of the same model: {export}.

## Macro steps

Time of a macro step [µs] for each component, the FMUs' own included: that is what a loop in C costs
which is written for the system alone. The ring's components feed one another with three Reals, the
chain's with one that goes through at once. Results are all outputs at each step.

{macro_steps}

The set-up of 200 FMU files with 600 links, from the system to its first step: {setup}.

## Not measured

{missing}

## How the engines are used

- **Pinocchio**: the wheel's own compiled algorithms, in the faster of its two conventions.
- **MuJoCo**: `mj_forward`; constraints, contacts, sensors, actuation and islands are switched off.
- **CasADi**: Lagrange's equations from its derivatives of the energies and its symbolic LDLᵀ.
- **SymPy**: `KanesMethod`, `lambdify` with `cse`, NumPy's solve. **PyDy**: its Cython generator.
- **pyM4E**: its own `integrate_dynamics` and `integrate`, in an environment of its own.
"""


def write_report(result: Mapping[str, Any], folder: Path) -> list[Path]:
    """Write both files; returns their paths."""
    page, picture = folder / "benchmark.md", folder / "benchmark.png"
    draw(result["right_hand_side"], picture)
    facts = {
        **result["machine"],
        "versions": ", ".join(f"{k} {v}" for k, v in result["versions"].items()),
    }
    text = [
        _HEAD.format(
            when=result["when"], machine="\n".join(f"| {k} | {v} |" for k, v in facts.items())
        ),
        "\n## Aims\n\n" + table(["quantity", "aim", "measured"], aims(result)) + "\n",
        _right_hand_side(result),
        _spiderfloat(result["spiderfloat"] or {}),
        _rest(result),
    ]
    page.write_text("".join(text), "utf-8")
    return [page, picture]


def table(head: Sequence[str], rows: Rows) -> str:
    """A Markdown table; a sentence where there are no rows."""
    lines = [f"| {' | '.join(row)} |" for row in rows]
    if not lines:
        return "Not measured in this run."
    return "\n".join([f"| {' | '.join(head)} |", "|---" * len(head) + "|", *lines])


def number(value: float | None, factor: float = 1.0) -> str:
    """Three significant digits without an exponent where that is readable; – for None."""
    if value is None:
        return "–"
    value *= factor
    if value == 0 or 1e-3 <= abs(value) < 1e4:
        digits = 3 if abs(value) < 1e3 else 4
        return f"{value:.{digits}g}"
    return f"{value:.1e}"


def _names(columns: Mapping[str, Mapping[str, Any] | None]) -> list[str]:
    return list(dict.fromkeys(name for column in columns.values() for name in column or {}))


def _right_hand_side(result: Mapping[str, Any]) -> str:
    columns = {n: values or {} for n, values in result["right_hand_side"].items()}
    head = ["engine", *(f"n = {n}" for n in columns)]
    names = _names(columns)
    times, ratios = [], []
    for name in names:
        values = [column.get(name) for column in columns.values()]
        peers = [column.get("Pinocchio ABA") for column in columns.values()]
        times.append([name, *(number(v, 1e6) for v in values)])
        pairs = zip(values, peers, strict=True)
        ratios.append([name, *(number(v / p if v and p else None) for v, p in pairs)])
    peer = (result["tree"] or {}).get("Pinocchio ABA")
    tree = [
        [name, number(v, 1e6), number(v / peer if peer else None)]
        for name, v in (result["tree"] or {}).items()
    ]
    return _RIGHT_HAND_SIDE.format(
        table=table(head, times),
        ratios=table(head, ratios),
        tree=table(["engine", "µs", "over Pinocchio"], tree),
    )


def _spiderfloat(found: Mapping[str, Mapping[str, float]]) -> str:
    factors = {"preparation": 1e3, "right_hand_side": 1e6, "integration": 1.0}
    rows = (
        [name, *(number(values[key], factor) for key, factor in factors.items())]
        for name, values in found.items()
    )
    return _SPIDERFLOAT.format(table=table(["engine", "ms", "µs", "s"], rows))


def _fmu_steps(found: Mapping[str, Mapping[str, float]]) -> dict[str, str]:
    slowest = max(found["steps"].values(), default=0.0)
    rows = ([k, number(v, 1e6), f"1/{slowest / v:.0f}"] for k, v in found["steps"].items())
    export = ", ".join(f"{k} {number(v, 1e3)} ms" for k, v in found["export"].items())
    return {
        "steps": table(["FMU", "µs", "over the lambdified one"], rows),
        "export": export or "not measured",
    }


def _macro_steps(found: Mapping[str, Any]) -> dict[str, str]:
    columns = found["steps"]
    rows = ([who, *(number(c.get(who), 1e6) for c in columns.values())] for who in _names(columns))
    setup = found["setup"]
    return {
        "macro_steps": table(["master", *columns], rows),
        "setup": "not measured" if setup is None else f"{number(setup)} s",
    }


def _rest(result: Mapping[str, Any]) -> str:
    integrations = [
        [n, name, number(v["seconds"]), str(round(v["evaluations"])), number(v["drift"])]
        for n, column in result["integration"].items()
        for name, v in (column or {}).items()
    ]
    preparation = result["preparation"] or {}
    sizes = sorted({int(n) for column in preparation.values() for n in column})
    peer = (result["derivatives"] or {}).get("Pinocchio computeABADerivatives")
    derivatives = [
        [name, number(v, 1e6), number(v / peer if peer else None)]
        for name, v in (result["derivatives"] or {}).items()
    ]
    whole, memory = result["process"], result["memory"]
    process = []
    if whole:
        process += [["`m4e-fmi simulate`, 30 s, wall", f"{number(whole['wall'])} s"]]
        process += [["the same, CPU", f"{number(whole['cpu'])} s"]]
    if memory is not None:
        process += [["memory beyond the imports", f"{number(memory / 1e6)} MB"]]
    return _REST.format(
        middle=result["middle"],
        integration=table(["n", "engine", "s", "evaluations", "drift"], integrations),
        preparation=table(
            ["engine", *(f"n = {n}" for n in sizes)],
            ([name, *(number(c.get(str(n))) for n in sizes)] for name, c in preparation.items()),
        ),
        derivatives=table(["what", "µs", "over Pinocchio's"], derivatives),
        ensemble=table(
            ["what", "s"], ([k, number(v)] for k, v in (result["ensemble"] or {}).items())
        ),
        accuracy=table(
            ["engine", "error"], ([k, number(v)] for k, v in (result["accuracy"] or {}).items())
        ),
        process=table(["what", "measured"], process),
        **_fmu_steps(result["fmu_steps"] or {"steps": {}, "export": {}}),
        **_macro_steps(result["macro_steps"] or {"steps": {}, "setup": None}),
        missing="\n".join(f"- {text}" for text in result["missing"]) or "Everything was measured.",
    )
