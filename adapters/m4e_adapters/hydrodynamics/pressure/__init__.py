"""Pressure of the water on the wetted part of a hull at its true pose: nonlinear, no small motions.

`config` has the keys, `closed_hull` makes the surface with its part above the water. `hull_load`
travels inside the FMU: it imports NumPy only. Start reading in `hull_load`.
"""
