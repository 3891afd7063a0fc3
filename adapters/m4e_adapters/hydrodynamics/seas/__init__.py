"""Waves: dispersion, spectra and components (`waves`), recorded with the excitation (`sea`).

`wave_forces` is what they are to a response over periods. Start reading in `sea`.
"""
