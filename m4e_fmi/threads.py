"""Locks of what one thread of a process may do at a time."""

from __future__ import annotations

import threading

ONE_RUN = threading.RLock()
"""Held by a run: FMUs may change what all threads have in common, as the working folder."""

NETCDF_LIBRARY = threading.RLock()
"""Held while a netCDF file is open: the library is not made for threads, and ends the process."""
