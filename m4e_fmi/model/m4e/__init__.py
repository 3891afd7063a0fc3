"""Importer of the paper's lists (M4E): S. Sabet and A. Diaz-Flores Caminero, sections 5.1, 5.2.

`lists` is what others call; `mechanism` reads bodies and joints, `forces` points and forces,
`points` the names of points. Imports the modules of `model` beside it. Start with `lists`.
"""

from m4e_fmi.model.m4e.lists import are_lists, model_from_lists, model_of_lists, normalize_prismatic

__all__ = ["are_lists", "model_from_lists", "model_of_lists", "normalize_prismatic"]
