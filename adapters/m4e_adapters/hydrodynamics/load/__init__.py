"""The load on floating bodies as a Program.

`motions` (inputs and displacements), `parts` (memory, hydrostatics, drag) and `outputs` meet in
`program`. Start reading in `program`.
"""
