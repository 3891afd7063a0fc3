"""FMUs in processes of their own, workers: a crash, a hang or an exit there is an error here.

Start reading at `process`: `Worker` is one FMU in its process, with a watchdog for its calls.
`keeper` is the program that starts workers, and what runs in them; one runs beside each master,
without any FMU, and clears up when the master is gone. The functions of FMI
that are performed in a worker are in the runtime's remote.h.
"""

from __future__ import annotations

from m4e_fmi.fmu.importer.worker.process import (
    LATE,
    LOST,
    Host,
    Worker,
    end_busy,
    function_names,
)

__all__ = ["LATE", "LOST", "Host", "Worker", "end_busy", "function_names"]
