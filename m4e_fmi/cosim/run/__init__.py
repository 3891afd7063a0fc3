"""A run of a system: stepped to its stop time or from Python, with results and checkpoints.

Start reading at `verbs` (`run`, `start`), then `running` (from the FMUs to the outcome: the results
file, errors that say how far it goes) and `run` (`Run`: the FMUs at a communication point, steps,
`save` and `restore`). `checkpoint` has the state of a run, and its form on the disk.
"""
