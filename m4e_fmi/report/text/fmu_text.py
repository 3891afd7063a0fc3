"""Contents of an FMU, as a table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from m4e_fmi.shown import one_line

ORDER = (
    "structuralParameter",
    "parameter",
    "calculatedParameter",
    "input",
    "output",
    "local",
    "independent",
)
REALS = ("Real", "Float64")
"""Types that are not told."""


def fmu_text(path: Path) -> str:
    """Identity, kinds, capabilities, platforms and variables of an FMU.

    An output is followed by the inputs and states it depends on; ``← ?`` where it declares none.
    """
    from m4e_fmi.fmu import fmu_contents

    found = fmu_contents(path)
    variables = found["variables"]
    kinds = " and ".join(found["kinds"])
    lines = [
        f"{path.name}: {found['modelName']}, FMI {found['fmiVersion']} {kinds}, "
        f"{len(variables)} variables",
        f"{found['size'] / 1e3:.0f} kB, {found['unpacked'] / 1e3:.0f} kB unpacked; platforms: "
        f"{', '.join(found['platforms']) or 'none'}{'; sources' if found['sources'] else ''}",
    ]
    if found["experiment"]:
        times = (f"{key} {value:g}" for key, value in found["experiment"].items())
        lines.append(f"default experiment: {', '.join(times)}")
    for kind, abilities in found["kinds"].items():
        told = (k if v is True else f"{k} {v}" for k, v in abilities.items())
        lines.append(f"{kind}: {', '.join(told)}")
    needs = {u["name"]: u["dependencies"] for u in found["structure"]["outputs"]}
    for causality in ORDER:
        chosen = [v for v in variables if v["causality"] == causality]
        if chosen:
            lines.append(f"{causality} ({len(chosen)})")
        lines += [_line(v, needs) for v in chosen]
    return "\n".join(lines)


def _line(variable: dict[str, Any], needs: dict[str, list[str] | None]) -> str:
    name = variable["name"]
    if variable.get("shape"):
        name += f"[{','.join(map(str, variable['shape']))}]"
    kind = variable["type"]
    unit = variable.get("unit", "-") if kind in REALS else kind
    if "items" in variable:
        unit += f" ({', '.join(variable['items'])})"
    line = f"  {name:<32} {unit:<10} {one_line(variable.get('description', ''))}"
    through = needs.get(name, [])
    if through is None:
        return f"{line}  ← ?"
    return line + (f"  ← {', '.join(through)}" if through else "")
