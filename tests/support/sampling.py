"""A sample of random cases for `make test`, all of them for `make verify`."""

from __future__ import annotations

import pytest


def blocks(sample: int, whole: int) -> list[object]:
    """Numbers up to before `whole`, those from `sample` on for `make verify`."""
    return [k if k < sample else pytest.param(k, marks=pytest.mark.verify) for k in range(whole)]
