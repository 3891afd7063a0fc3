"""Instances of FMUs, the values between them, and operations performed in C and in Python.

Start reading at `network`, whose values have the places of `layout`. `loading/` loads the FMUs,
`instance` calls one. `operations` are performed by `step_loop`, in C (`native_executor`) or Python
(`python_executor`). `newton` solves algebraic loops, `discrete` exchanges values that are not Real;
`events`, `interruption` and `fmu_log` are about events, signals and messages.
"""
