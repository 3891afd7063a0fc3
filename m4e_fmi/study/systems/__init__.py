"""Studies of a system: versions of components, their FMUs, tasks for executors.

Start reading at `plan`, then `variants` (as few FMUs as possible), `task` and `execution`.
"""
