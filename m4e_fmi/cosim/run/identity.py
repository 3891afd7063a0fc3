"""Identity of a run: everything that must be equal when it continues from a checkpoint.

The stop time and the times of checkpoints may differ. Everything else that affects the results is
listed by name and value: the version of m4e_fmi, the platform (the binaries of an FMU for two
platforms may have states of different form), the FMUs by their SHA-256, start values, connections,
actions of the scenario, settings, recorded variables.
"""

from __future__ import annotations

import platform
import re
import sys
from collections.abc import Mapping
from dataclasses import fields

import m4e_fmi
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.errors import InputError
from m4e_fmi.units import Quantity

FREE = ("stop_time", "checkpoint_interval", "checkpoint_wall_interval")
"""Settings of a simulation that may differ."""
_SHA_256 = re.compile(r"\b([0-9a-f]{12})[0-9a-f]{52}\b")
_SHOWN = 60
"""Characters of a value that a message shows."""


def identity(prepared: Prepared, *, certify: bool) -> dict[str, str]:
    """All that the results of a run follow from, by name; with `certify` its error is estimated."""
    system = prepared.system
    found = {
        "the version of m4e_fmi": m4e_fmi.__version__,
        "the platform": f"{sys.platform} {platform.machine()}",
    }
    for component in system.components:
        name, description = component.name, prepared.descriptions[component.name]
        content = f"{description.path.name}, SHA-256 {description.content}"
        found[f"the file of {name}'s FMU"] = content
        found |= {
            # a Quantity with all its digits
            f"start value {name}.{v}": f"{given.value!r} {given.unit.text}"
            if isinstance(given, Quantity)
            else str(given)
            for v, given in component.start.items()
        }
        found |= {f"unit of {name}.{v}": str(unit) for v, unit in component.units.items()}
        found[f"step_size of {name}"] = str(component.step_size)
        dependencies = {v: sorted(needs) for v, needs in component.dependencies.items()}
        found[f"dependencies of {name}"] = str(dependencies)
        found[f"rollback of {name}"] = str(description.saves_state)
        found[f"recorded variables of {name}"] = ", ".join(
            variable.name for variable in prepared.recorded.get(name, ())
        )
    found["the order of the components"] = ", ".join(c.name for c in system.components)
    found["connections"] = "; ".join(system.connections)
    found["inputs of the system"] = str({k: list(v) for k, v in system.inputs.items()})
    found["the order of the actions"] = ", ".join(system.scenario)
    for name, action in system.scenario.items():
        found |= {f"{key!r} of action {name}": str(value) for key, value in action.given.items()}
    settings = system.simulation
    found |= {
        f.name: str(getattr(settings, f.name)) for f in fields(settings) if f.name not in FREE
    }
    found["the error estimate"] = "on" if certify else "off"
    return found


def check_identity(path: str, saved: Mapping[str, str], present: Mapping[str, str]) -> None:
    """InputError that names all that differs between the checkpoint at `path` and the run."""
    names = [n for n in {**saved, **present} if saved.get(n) != present.get(n)]
    if not names:
        return
    differ = [f"{n} was {_shown(saved.get(n))}, and is {_shown(present.get(n))}" for n in names]
    message = f"the checkpoint is of another run: {'; '.join(differ)}"
    raise InputError.single(message, "give it as it was, or run again from the start", path)


def _shown(value: str | None) -> str:
    if value is None:
        return "not given"
    value = _SHA_256.sub(r"\1", value)
    return value if len(value) <= _SHOWN else f"{value[:_SHOWN]} …"
