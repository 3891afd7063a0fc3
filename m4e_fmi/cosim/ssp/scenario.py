"""Scenarios in packages: SSP has no word for them, so they are in our own annotation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from m4e_fmi.cosim.ssp.package import Package
from m4e_fmi.cosim.system.scenario_section import Action
from m4e_fmi.cosim.system.system import System


def annotated_scenario(system: System) -> dict[str, Any]:
    """Content of the annotation of a package about the system's scenario."""
    found = {
        name: action.model_dump(mode="json", by_alias=True, exclude_none=True, exclude_unset=True)
        for name, action in system.scenario.items()
    }
    return {"scenario": found} if found else {}


def scenario_in(package: Package, told: Mapping[str, Any]) -> dict[str, Action]:
    """The scenario that the annotation of a package tells of; a note if it is not one."""
    written = told.get("scenario", {})
    try:
        return {str(name): Action.model_validate(keys) for name, keys in dict(written).items()}
    except (ValidationError, TypeError, ValueError):
        package.note("its scenario is not one that is understood here: it is left out")
        return {}
