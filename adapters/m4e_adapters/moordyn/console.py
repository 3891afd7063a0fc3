"""Console output of a library, kept instead of shown.

Travels inside the FMU: imports the standard library only.
"""

import contextlib
import ctypes
import os
import tempfile


class Console:
    """Collects what is written to file descriptors 1 and 2."""

    def __init__(self, file):
        self._file = file
        self.text = ""

    def write(self, data):
        """Add these bytes."""
        os.write(self._file.fileno(), data)

    def finish(self):
        """Make `text` of all that was written."""
        self._file.seek(0)
        self.text = self._file.read().decode("utf-8", "replace")


@contextlib.contextmanager
def console_kept():
    """Keep the process's standard output and error, C++ included, in a file meanwhile."""
    with tempfile.TemporaryFile() as file:
        console = Console(file)
        _flush_c_streams()
        saved = []
        try:
            for descriptor in (1, 2):
                with contextlib.suppress(OSError):  # closed, as in a program without a console
                    saved.append((descriptor, os.dup(descriptor)))
                    os.dup2(file.fileno(), descriptor)
            yield console
        finally:
            _flush_c_streams()
            for descriptor, copy in saved:
                os.dup2(copy, descriptor)
                os.close(copy)
            console.finish()


def _flush_c_streams():
    if os.name == "posix":
        ctypes.CDLL(None).fflush(None)
