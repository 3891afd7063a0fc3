"""Studies of a system: what varied names stand for, versions of components, tasks for executors.

Start reading at `targets`, then `variants` (as few FMUs as possible), `plan` and `task`.
"""
