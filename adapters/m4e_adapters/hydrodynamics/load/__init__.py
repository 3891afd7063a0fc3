"""The load on floating bodies as a Program.

`motions` (inputs and displacements), `parts` (memory, hydrostatics, drag) and `outputs` meet in
`program`; `small_motions` has the limits of linear hydrodynamics. Start reading in `program`.
"""
