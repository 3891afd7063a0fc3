"""The way of a wave height from the file to the force on the hulls is that of the docs."""

from __future__ import annotations

import shutil
from pathlib import Path

from support.walks import Ways, documented, traced

from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.config.waves import Regular
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_fmi.cosim import System, load_system
from m4e_fmi.cosim.preparation.components import expected_descriptions
from m4e_fmi.cosim.system.component import Component, Kind

EXAMPLE = Path(__file__).parents[4] / "examples" / "two_flaps"
HEIGHT = "1.5432"
JONSWAP = "{spectrum: jonswap, significant_height: 1.5, peak_period: 8, seed: 1}"
REGULAR = f"{{spectrum: regular, height: {HEIGHT}, period: 8}}"
CARRIERS = (HydrodynamicsConfig, Kind, Component, System, Regular, WaveSystem)


def is_height(value: object) -> bool:
    """True for the height, and what has it: sections, the component, the system, its waves."""
    return isinstance(value, CARRIERS) or (type(value) in (str, float) and str(value) == HEIGHT)


def test_a_wave_height_passes_the_files_that_the_docs_name(tmp_path: Path) -> None:
    for name in ("flaps.model.yaml", "flaps.nc"):
        shutil.copy(EXAMPLE / name, tmp_path)
    text = (EXAMPLE / "system.yaml").read_text("utf-8")
    assert JONSWAP in text
    (tmp_path / "system.yaml").write_text(text.replace(JONSWAP, REGULAR), "utf-8")
    ways = Ways(is_height)
    with traced(ways.seen):
        system = load_system(tmp_path / "system.yaml")
        expected_descriptions(system)  # as a build, with a flow of nothing
    names = documented("A wave height from file to force")
    assert len(names) <= 7
    cut = names.index("m4e_fmi/cosim/preparation/components.py")  # which this test hands the system
    loaded, built = names[:cut], names[cut:]
    assert loaded in ways.shortest(loaded[0], loaded[-1])
    *built, halved = built
    assert built in ways.shortest(built[0], built[-1])
    assert ways.graph.has_edge(built[-1], halved)
