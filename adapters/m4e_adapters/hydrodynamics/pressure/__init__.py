"""Pressure of the water on the wetted part of a hull at its true pose: nonlinear, no small motions.

`config` has the keys, `closed_hull` makes the surface with its part above the water. `hull_load`
and `hull_outputs` travel inside the FMU: they import NumPy and each other only. Start reading in
`hull_load`.
"""
