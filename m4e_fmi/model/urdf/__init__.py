"""Models from URDF, the robots' description format (wiki.ros.org/urdf/XML), version 1.0.

`reading` gives the links and joints of a file with their lines, `importer` makes a model in space
of them. Imports the modules of `model` beside it. Start with `importer`.
"""

from m4e_fmi.model.urdf.importer import model_of_urdf

__all__ = ["model_of_urdf"]
