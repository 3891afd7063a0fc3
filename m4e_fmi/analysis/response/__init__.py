"""Response of systems to waves: transfer functions (RAOs), and statistics in irregular seas.

Small waves: the linear equations. Waves of a given height, and seas: loads such as drag are
linearised for the motion that they limit (harmonic balance; statistical linearisation).
Imports `m4e_fmi.analysis` below it. Start with `waves`, then `wave_response` and `sea_response`.
"""

from m4e_fmi.analysis.response.sea_response import SeaResponse, sea_response
from m4e_fmi.analysis.response.wave_response import WaveResponse, wave_response
from m4e_fmi.analysis.response.waves import InWaves, Sea, WaveForces

__all__ = [
    "InWaves",
    "Sea",
    "SeaResponse",
    "WaveForces",
    "WaveResponse",
    "sea_response",
    "wave_response",
]
