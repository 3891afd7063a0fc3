"""True over stated coupling errors of 300 random systems: contacts, switches, no way back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.eventful_systems import samples

from m4e_fmi.cosim import CouplingErrorReport, Outcome

SEED, COUNT = 13, 300
ALGORITHMS = ("corrector", "gauss_seidel", "jacobi", "implicit")


def test_true_over_stated(c_fmu: Callable[[str], Path], capsys: pytest.CaptureFixture[str]) -> None:
    systems = samples(c_fmu, SEED, COUNT, ALGORITHMS)
    ratios, unsure = [], 0
    with capsys.disabled():
        print(f"\nseed {SEED}, {COUNT} systems")
        for k, system in enumerate(systems):
            true, stated, outcome = system.true_and_stated()
            ratios.append(true / stated)
            unsure += _is_unsure(outcome)
            settings = system.system.simulation
            print(
                f"{k:3d} {settings.algorithm:12} {system.event:8} rigid={system.rigid:d} "
                f"nonlinear={system.nonlinear:d} steps={outcome.steps:5d}"
                f" at={system.moment / settings.stop_time:.2f} true={true:.2e} stated={stated:.2e} "
                f"ratio={true / stated:.3g}"
            )
        found = np.array(ratios)
        print(
            f"median {np.median(found):.2f}, {found.min():.2g} to {found.max():.3g}; above 3: "
            f"{(found > 3).sum()}, below 0.2: {(found < 0.2).sum()}, unsure: {unsure}"
        )
    assert np.isfinite(found).all()
    assert found.max() <= 3
    assert 0.2 <= np.median(found) <= 1
    assert unsure <= COUNT / 20
    eventful = [s for s in systems if s.event in ("contact", "impact", "switch")]
    assert len(eventful) >= 100
    assert sum(s.rigid for s in systems) >= 50
    assert sum(s.nonlinear for s in systems) == COUNT // 2


def _is_unsure(outcome: Outcome) -> bool:
    certificate = outcome.certificate
    if not isinstance(certificate, CouplingErrorReport) or certificate.coverage is None:
        return True
    return bool(certificate.coverage.lost)
