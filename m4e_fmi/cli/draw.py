"""`m4e-fmi draw` draws a model in its start pose."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.shared.log import print_files
from m4e_fmi.cli.shared.options import BUILD_FOLDER, MODEL_FILE, load_model


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `draw`."""
    command.add_argument("model", type=Path, help=MODEL_FILE)
    command.add_argument(
        "--output-file",
        type=Path,
        metavar="FILE",
        help=".png, .svg or .pdf; default build/NAME_model.png",
    )
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.files.file_names import file_stem
    from m4e_fmi.report import draw_model

    model = load_model(options.model)
    picture = options.output_file or Path(BUILD_FOLDER) / f"{file_stem(model.name)}_model.png"
    print_files([draw_model(model, picture)])
