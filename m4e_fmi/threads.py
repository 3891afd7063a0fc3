"""Locks of what one thread of a process may do at a time."""

from __future__ import annotations

import threading

ONE_RUN = threading.RLock()
"""Held by a run: FMUs may change what all threads have in common, as the working folder."""

PROCESS = threading.RLock()
"""Held by what uses or changes something that all threads have: netCDF's library, which ends the
process if two threads call it, while a file is open; the working folder while it is another one."""
