"""Coefficients from files of other programs: WAMIT, BEMIO (WEC-Sim), Capytaine.

A reader for each format (`wamit`, `bemio`, `capytaine_file`) gives `FileData`, as the file has it;
`from_file` makes `Coefficients` of it: bodies and water of the configuration, motions about centres
of gravity, A∞, wave directions. `consistency` says how sound they are. Start in `from_file`.
"""
