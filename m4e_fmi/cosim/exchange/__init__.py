"""Instances of FMUs, the values between them, and operations performed by the C library.

Start reading at `network`, whose values have the places of `layout`. `loading/` loads the FMUs,
`instance` calls one. `operations` are the calls of a step as data; `schedule` compiles them for the
C library, which performs them. `newton` solves algebraic loops, `discrete`
exchanges values that are not Real; `events`, `interruption` and `fmu_log` are about events, signals
and messages.
"""
