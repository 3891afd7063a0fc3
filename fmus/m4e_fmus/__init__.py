"""Kinds of FMU for system files: one folder per kind, found by the entry points of pyproject.toml.

A kind is an `FmuKind`: the class of what stands below `kind: …` in a system file, and what turns
such a configuration into a Program or a Python slave. `water/` has the checks of systems in water,
which several kinds share. The README of each has the equations and variables,
`reference.yaml` and `reference.csv` a configuration and the series that it must give. Kinds are
found through the entry-point group `m4e_fmi.fmus`; other packages add theirs there. May import
`m4e_adapters` and `m4e_fmi`; a file called `slave.py` travels inside the FMU and may not.
"""
