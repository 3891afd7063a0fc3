"""Online estimate of the coupling error: step doubling in windows, or a shadow run.

Start reading at `step_doubling`; `estimator` chooses between the two. Step doubling repeats windows
of the run (`repeated_windows`, `repeated_steps`, `step_times`) and follows it about kinks, which
`roughness` finds and `kinks` groups; its knowledge is in `state`, `stretch` and `coverage`.
`windows` extrapolates to the whole run, `report` makes the certificate.
"""
