"""What the runtime aims at, beside what was measured."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from benchmark.fmu_steps import C_HOST, CTYPES, PYTHON
from benchmark.measure import MODELS

COMPILED, INTERPRETED, PINOCCHIO = "m4e_fmi compiled", "m4e_fmi interpreted", "Pinocchio ABA"


def aims(result: Mapping[str, Any]) -> list[list[str]]:
    """Rows of quantity, aim, measured; a quantity that was not measured shows –."""
    middle = str(result["middle"])
    rhs = result["right_hand_side"]
    runs = result["integration"]
    derivatives, ensemble = result["derivatives"] or {}, result["ensemble"] or {}
    ours = (result["preparation"] or {}).get(INTERPRETED, {})
    steps = (result["fmu_steps"] or {}).get("steps", {})
    rows = [
        (f"right-hand side, interpreted, n = {n}, over Pinocchio", "≤ 1/2.5",
         _ratio(rhs.get(n), INTERPRETED, PINOCCHIO))
        for n in ("10", "60", "200")
    ]  # fmt: skip
    rows += [
        (f"right-hand side, compiled, n = {n}, over Pinocchio", "≤ 1/10",
         _ratio(rhs.get(n), COMPILED, PINOCCHIO))
        for n in ("10", "60")
    ]  # fmt: skip
    for n, kind, aim in (
        ("1", COMPILED, "≤ 1/300"),
        (middle, INTERPRETED, "≤ 1/2000"),
        (middle, COMPILED, "≤ 1/8000"),
    ):
        title = f"30 s, RK45, {kind.split()[1]}, n = {n}, over pyM4E"
        rows.append((title, aim, _run_ratio(runs.get(n), kind, "pyM4E, RK45")))
    for kind, aim in ((INTERPRETED, "≤ 1/10"), (COMPILED, "≤ 1/14")):
        for peer in ("Pinocchio", "MuJoCo"):
            title = f"30 s, {kind.split()[1]}, n = {middle}, over the same integrator with {peer}"
            other = f"same integrator, {peer}, RK45"
            rows.append((title, aim, _run_ratio(runs.get(middle), kind, other)))
    rows += [
        ("model to program, n = 60", "≤ 20 ms", _scaled(ours.get("60"), 1e3, "ms")),
        ("model to program, n = 500", "≤ 200 ms", _scaled(ours.get("500"), 1e3, "ms")),
        ("growth of that with n, 60 to 500", "≤ n^1.2", _growth(ours)),
        ("one directional derivative over a right-hand side", "≤ 2",
         _ratio(derivatives, "m4e_fmi directional derivative", "m4e_fmi right-hand side")),
        (f"Jacobian, n = {middle}, over Pinocchio's", "≤ 1, with 1/15 in reach",
         _ratio(derivatives, "m4e_fmi Jacobian", "Pinocchio computeABADerivatives")),
        (f"ensemble, compiled, per model, n = {middle}, over Pinocchio", "≤ 1/15", _ratio(
            ensemble, f"m4e_fmi compiled, {MODELS} models at once", "same integrator, Pinocchio")),
        (f"accuracy, n = {middle}", "≤ 1e-14",
         _scaled((result["accuracy"] or {}).get(INTERPRETED), 1, "")),
        (f"energy drift, DOP853, n = {middle}", "≤ 2e-8", _drift(runs.get(middle))),
        (f"whole process, n = {middle}, wall", "≤ 1 s",
         _scaled((result["process"] or {}).get("wall"), 1, "s")),
        (f"memory beyond the imports, n = {middle}", "≤ 20 MB",
         _scaled(result["memory"], 1e-6, "MB")),
        ("step of an FMU, n = 10, from Python", "≤ 8 µs", _scaled(steps.get(CTYPES), 1e6, "µs")),
        ("the same over a lambdified one's", "≤ 1/25", _ratio(steps, CTYPES, PYTHON)),
        ("the same from C", "≤ 1/100", _ratio(steps, C_HOST, PYTHON)),
        *_macro_steps(result["macro_steps"] or {"steps": {}, "setup": None}),
    ]  # fmt: skip
    return [list(row) for row in rows]


def _macro_steps(found: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    rows = []
    for what, costs in found["steps"].items():
        floor, native = costs.get("loop in C"), costs.get("m4e_fmi jacobi")
        observed = costs.get("m4e_fmi jacobi, observed by Python")
        written = costs.get("m4e_fmi jacobi, results written")
        over = [v - floor if floor and v else None for v in (native, observed)]
        rows += [
            (f"macro step of a component, {what}, beside its FMU's own", "≤ 0.15 µs",
             _scaled(over[0], 1e6, "µs")),
            ("the same, observed by Python", "≤ 2 µs", _scaled(over[1], 1e6, "µs")),
            ("the same with results written, over the first", "≤ 2", _fraction(written, native)),
        ]  # fmt: skip
    rows.append(
        ("set-up of 200 FMU files with 600 links", "≤ 1.5 s", _scaled(found["setup"], 1, "s"))
    )
    return rows


def _fraction(ours: float | None, peer: float | None) -> str:
    if not ours or not peer:
        return "–"
    ratio = peer / ours
    if ratio >= 1:
        return f"1/{ratio:.3g}" if ratio < 100 else f"1/{ratio:.0f}"
    return f"{1 / ratio:.3g}"


def _ratio(values: Mapping[str, float] | None, ours: str, peer: str) -> str:
    return _fraction((values or {}).get(ours), (values or {}).get(peer))


def _run_ratio(runs: Mapping[str, Any] | None, kind: str, peer: str) -> str:
    runs = runs or {}
    seconds = [runs.get(name, {}).get("seconds") for name in (f"{kind}, RK45", peer)]
    return _fraction(*seconds)


def _drift(runs: Mapping[str, Any] | None) -> str:
    return _scaled((runs or {}).get(f"{INTERPRETED}, DOP853", {}).get("drift"), 1, "")


def _growth(ours: Mapping[str, float]) -> str:
    small, large = ours.get("60"), ours.get("500")
    return f"n^{math.log(large / small) / math.log(500 / 60):.2f}" if small and large else "–"


def _scaled(value: float | None, factor: float, unit: str) -> str:
    return "–" if value is None else f"{value * factor:.2g} {unit}".strip()
