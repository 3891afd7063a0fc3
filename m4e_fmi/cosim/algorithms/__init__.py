"""How all components make one step together: one file per algorithm, found by its name.

Each file ends with its descriptor, `ALGORITHM` (see `m4e_fmi/coupling_algorithms.py`). To add an
algorithm, add a file: its class derives from `Scheduled` if it performs the same operations in
every step, or has the methods of `Algorithm`; both are in `m4e_fmi/cosim/stepping/`, as are the
parts that algorithms share. Start reading at `jacobi.py`, the shortest.
"""

from m4e_fmi.coupling_algorithms import FOLDERS

__path__ = FOLDERS
