"""docs/fmus/keys.md: every key of the kinds with many, as the schema has it.

`pytest --update` writes the page anew.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from doc_tools.schema_page import models, schema_text

from m4e_adapters.hydrodynamics import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.pressure.config import HullPressureConfig
from m4e_adapters.moordyn.config import MooringConfig
from m4e_adapters.morison import MorisonConfig
from m4e_adapters.sea import SeaConfig
from m4e_adapters.wind import WindConfig

PAGE = Path(__file__).parents[2] / "docs" / "fmus" / "keys.md"
KINDS = {
    "hydrodynamics": HydrodynamicsConfig,
    "hull_pressure": HullPressureConfig,
    "mooring": MooringConfig,
    "morison": MorisonConfig,
    "sea": SeaConfig,
    "wind": WindConfig,
}


def test_the_page_is_what_the_schema_says(request: pytest.FixtureRequest) -> None:
    text = PAGE.read_text(encoding="utf-8")
    tables = "\n".join(schema_text(title, config) for title, config in KINDS.items())
    expected = text[: text.index("## hydrodynamics")] + tables
    if request.config.getoption("--update"):
        PAGE.write_text(expected, encoding="utf-8")
        text = expected
    assert text == expected


@pytest.mark.parametrize("kind", KINDS)
def test_sections_say_what_their_numbers_are(kind: str) -> None:
    """Every key with a number is named where its section is described, with its unit there."""
    for model in models(KINDS[kind]).values():
        for key, field in model.model_fields.items():
            if "float" in repr(field.annotation) and "Section" not in repr(field.annotation):
                assert re.search(rf"\b{key}\b", (model.__doc__ or "").lower()), (model, key)
