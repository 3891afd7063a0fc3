"""Examples of wave-energy converters with files of coefficients: responses and coupled runs.

From their geometry, and all periods: `tests/verify/test_converters.py`.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.coefficient_files import rm3_files
from support.converters import EXAMPLES, apart, copied, energy_lost

RM3, OSWEC = EXAMPLES / "rm3", EXAMPLES / "oswec"


@pytest.mark.verifies(
    "RM3 from WAMIT files, heave of both bodies in small waves of 4 and 14 s: RAO",
    independent="first harmonic of coupled FMUs in regular waves",
    tolerance="1e-4",
)
def test_small_waves_at_rm3(tmp_path: Path) -> None:
    """The files have rows of heave only, whose memory is fitted at once."""
    path = copied(RM3 / "system_wamit.yaml", tmp_path)
    rm3_files(tmp_path / "wamit", modes=(3, 9))
    for period in (4.0, 14.0):
        names = ["wec.body.float.z", "wec.body.spar.z", "wec.joint.guide.q"]
        found = apart(path, period, names, tmp_path)
        assert max(found) < 1e-4


@pytest.mark.verifies(
    "OSWEC from a file of Capytaine, angle in small waves of 4 and 14 s: RAO",
    independent="first harmonic of coupled FMUs in regular waves",
    tolerance="1e-4",
)
def test_small_waves_at_the_flap(tmp_path: Path) -> None:
    path = copied(OSWEC / "system_capytaine.yaml", tmp_path)
    for period in (4.0, 14.0):
        found = apart(path, period, ["wec.joint.hinge.q"], tmp_path)
        assert max(found) < 1e-4


@pytest.mark.verifies(
    "OSWEC in an irregular sea: energy lost or made by the coupling, of that exchanged",
    analytic="none is lost",
    tolerance="1e-3",
)
def test_energy_of_the_flap_in_a_sea(tmp_path: Path) -> None:
    path = copied(OSWEC / "system_capytaine.yaml", tmp_path)
    assert energy_lost(path, tmp_path) < 1e-3
