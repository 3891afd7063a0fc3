"""Second-order drift of a body."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from m4e_adapters.hydrodynamics.config.numbers import Place, Positive
from m4e_fmi.files.document import Section


class Drift(Section):
    """Slowly varying second-order forces of the waves, from a `file` beside the system file.

    Mean drift, for Newman's approximation: WAMIT's .7, .8 or .9, or CSV with columns omega [rad/s],
    direction [deg], surge, sway [N/m2], yaw [N.m/m2]. Full difference-frequency QTFs: WAMIT's .10d,
    .11d or .12d. `body` is the number of the body in a WAMIT file; `length_scale` [m] is its ULEN.
    `reference_point` [x, z], [x, y, z] in space, [m] is where the origin of the file's axes lies in
    the reference pose, about which its moments are; default: the centre of gravity.
    """

    file: str
    body: Annotated[int, Field(ge=1)] = 1
    length_scale: Positive = 1.0
    reference_point: Place | None = None
