"""Models from Project Chrono's YAML files of multibody models (data/yaml/schema in its sources).

What moves in the X–Z plane becomes a Model of the plane, all else one of space; what cannot be
represented is an error with its place and a remedy. `sections` is the form of the files, `rotation`
turns orientations into angles, `mechanism` and `loads` convert, `planar` projects what stays in the
plane, `importer` is what others call. Imports the modules of `model` beside it. Start with
`importer`.
"""

from m4e_fmi.model.chrono.importer import model_of_chrono

__all__ = ["model_of_chrono"]
