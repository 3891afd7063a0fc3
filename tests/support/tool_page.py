"""The page of another tool in a process of its own: tools load libraries that clash in one."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from doc_tools.run_page import run_page


def called_elsewhere(
    page: Path, folder: Path, module: str | None, calls: Sequence[tuple[Any, ...]]
) -> list[Any]:
    """What the page's function `run` returns for the arguments of each call.

    Raises what `module`, the tool's own, raises when it is imported.
    """
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(_called, page, folder, module, calls).result()


def _called(
    page: Path, folder: Path, module: str | None, calls: Sequence[tuple[Any, ...]]
) -> list[Any]:
    if module:
        import_module(module)
    run = run_page(page, folder)["run"]
    return [run(*arguments) for arguments in calls]
