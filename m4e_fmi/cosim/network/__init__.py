"""Instances of FMUs, the values between them, and operations performed by the C library.

Start reading at `network`: all exchanged values, their places, the operations that get and set
them. `loading` loads the FMUs, `instance` calls one. `operations` are the calls of a step as data;
`schedule` compiles them for the C library, which performs them. `arrivals` are outputs that are
read straight after steps, `discrete` exchanges values that are not Real, `newton` solves algebraic
loops; `restorable` is the base of all that has a state, also in packages above this;
`interruption` and `fmu_log` are about signals and messages.
"""
