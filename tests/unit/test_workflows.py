"""Workflow and hooks for a public forge: versions and commands that the project has."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from packaging.specifiers import SpecifierSet
from ruamel.yaml import YAML

ROOT = Path(__file__).parents[2]
MAKEFILE = (ROOT / "Makefile").read_text("utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


def loaded(path: str) -> Any:
    return YAML(typ="safe").load((ROOT / path).read_text("utf-8"))


def test_the_matrix_has_the_versions_of_python_that_the_package_takes() -> None:
    takes = SpecifierSet(PROJECT["requires-python"])
    versions = [f"3.{minor}" for minor in range(30) if takes.contains(f"3.{minor}")]
    jobs = loaded(".github/workflows/tests.yml")["jobs"]
    assert jobs["test"]["strategy"]["matrix"]["python"] == versions
    alone = [s["with"]["python-version"] for j in ("docs", "wheels") for s in jobs[j]["steps"][1:2]]
    assert set(alone) <= set(versions)


def test_commands_of_workflow_and_contributing_are_in_the_makefile() -> None:
    targets = set(re.findall(r"^([a-z]+):", MAKEFILE, re.MULTILINE))
    workflow = (ROOT / ".github/workflows/tests.yml").read_text("utf-8")
    page = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    used = set(re.findall(r"(?:^|`|run: )make ([a-z]+)", workflow + page, re.MULTILINE))
    assert {"test", "docs", "platforms", "check"} <= used <= targets


def test_hooks_run_tools_that_make_setup_installs() -> None:
    tools = {re.split(r"[\[=><]", need)[0] for need in PROJECT["optional-dependencies"]["test"]}
    (local,) = loaded(".pre-commit-config.yaml")["repos"]
    entries = [hook["entry"].split()[0] for hook in local["hooks"]]
    assert len(entries) == 4
    assert {entry.removeprefix(".venv/bin/") for entry in entries} <= tools
