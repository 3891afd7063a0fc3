"""Potential flow: Capytaine, its solutions kept by content.

`bem` goes from hulls to coefficients, with `flow_solver` for one frequency and `cache` for all that
was solved before. Start reading in `bem`.
"""
