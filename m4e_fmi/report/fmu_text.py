"""What is in an FMU, as a table."""

from __future__ import annotations

from pathlib import Path

ORDER = ("parameter", "calculatedParameter", "input", "output", "local", "independent")


def fmu_text(path: Path) -> str:
    """Identity and variables of an FMU; for an output, the inputs it depends on directly."""
    from m4e_fmi.fmu import read_description

    description = read_description(path)
    count = len(description.variables)
    lines = [f"{path.name}: {description.identifier}, FMI 2.0 co-simulation, {count} variables"]
    for causality in ORDER:
        variables = description.of_causality(causality)
        if variables:
            lines.append(f"{causality} ({len(variables)})")
        for variable in variables:
            line = f"  {variable.name:<32} {variable.unit or '-':<10} {variable.description}"
            through = sorted(description.dependencies.get(variable.name, ()))
            lines.append(line + (f"  ← {', '.join(through)}" if through else ""))
    return "\n".join(lines)
