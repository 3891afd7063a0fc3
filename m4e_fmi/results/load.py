"""Results of any kind from their file: of runs, simulations and studies."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.errors import InputError
from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.results import results_file
from m4e_fmi.results.results_file import Results, is_of_study
from m4e_fmi.threads import PROCESS

if TYPE_CHECKING:
    import xarray


def load(path: str | Path) -> Results | xarray.Dataset:
    """The results in a file that a run or a simulation has written; of a study its data set.

    Of a run that goes on or was killed: all rows that had reached the disk, each of them complete.
    InputError for a file that is not there, empty, damaged, too large, of another kind or of a
    newer form.
    """
    if not is_of_study(as_path(path)):
        return results_file.load(path)
    import xarray

    try:
        with PROCESS:
            return xarray.load_dataset(path, engine="netcdf4", decode_timedelta=False)
    except (OSError, RuntimeError, ValueError) as error:
        message, remedy = f"is cut off or damaged: {error}", "copy it again, or run again"
        raise InputError.single(message, remedy, str(path)) from None
