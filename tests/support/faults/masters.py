"""Ends of the program itself: killed inside a write, and a disk that is too small."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any


def dying_in_a_write(number: int, part: float) -> None:
    """Have this process kill itself inside the write of that number, after a part of its bytes.

    Writes are those of rows into the results file, and the files that are to appear as a whole.
    """
    from m4e_fmi.results import row_file

    usual_put, usual_fsync = row_file.RowFile._put, os.fsync
    count = 0

    def is_due() -> bool:
        nonlocal count
        count += 1
        return count > number

    def put(file: row_file.RowFile, place: int, data: Any) -> None:
        data = memoryview(data).cast("B")
        if is_due():
            usual_put(file, place, data[: int(part * len(data))])
            os.kill(os.getpid(), signal.SIGKILL)
        usual_put(file, place, data)

    def fsync(descriptor: int) -> None:
        name = Path(f"/proc/self/fd/{descriptor}").readlink().name
        if name.startswith(".part-") and is_due():
            os.ftruncate(descriptor, int(part * os.fstat(descriptor).st_size))
            os.kill(os.getpid(), signal.SIGKILL)
        usual_fsync(descriptor)

    setattr(row_file.RowFile, "_put", put)  # noqa: B010
    os.fsync = fsync  # pyrefly: ignore[bad-assignment]


@contextlib.contextmanager
def small_disk(folder: Path, size: int) -> Iterator[bool]:
    """A disk of `size` bytes in a folder; False, and nothing done, where none can be mounted."""
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    if os.geteuid() or subprocess.run(command, check=False, capture_output=True).returncode:
        yield False
        return
    try:
        yield True
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def enlarge(folder: Path, size: int) -> None:
    """Give a small disk more room."""
    subprocess.run(["mount", "-o", f"remount,size={size}", str(folder)], check=True)
