"""Models in space from Project Chrono's YAML files of multibody models (data/yaml/schema there).

What cannot be represented is an error with its place and a remedy. `sections` is the form of the
files, `mechanism` and `loads` convert, `importer` is what others call. Imports the modules of
`model` beside it. Start with `importer`.
"""

from m4e_fmi.model.chrono.importer import model_of_chrono

__all__ = ["model_of_chrono"]
