"""Reading a model file: detects its format and calls the importer (YAML, lists, Chrono, URDF)."""

from __future__ import annotations

from pathlib import Path

from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.files.file_kinds import MODEL, URDF_SUFFIX, as_path, check_keys
from m4e_fmi.model.m4e import are_lists, model_of_lists
from m4e_fmi.model.model import Model
from m4e_fmi.model.yaml import model_of


def load_model(path: str | Path) -> Model:
    """The model in the file `path`; InputError with every problem of the file.

    A `*.model.yaml` file of ours, a Chrono model (or simulation) in YAML, the paper's lists as YAML
    or JSON, or a robot in URDF (`*.urdf`).
    """
    if as_path(path).suffix.lower() == URDF_SUFFIX:
        from m4e_fmi.model.urdf import model_of_urdf

        return model_of_urdf(path)
    document = Document.load(path)
    check_keys(document.path, document.data, MODEL)
    if "model" in document.data:
        from m4e_fmi.model.chrono import model_of_chrono

        return model_of_chrono(document)
    if are_lists(document.data):
        return model_of_lists(document)
    return model_of(document)


def as_model(given: Model | str | Path) -> Model:
    """The Model itself, or the one in the file at a path; InputError for anything else."""
    match given:
        case Model():
            return given
        case str() | Path():
            return load_model(given)
        case _:
            kind = type(given).__name__
            raise InputError.single(f"expected a Model, or the path of a model file; got {kind}")
