"""Second-order drift: slowly varying forces of the differences of wave frequencies.

`tables` has the data, `files` reads them, `far_field` computes a table for a hull. `recording`
makes sums over pairs of waves sums over waves, and records these; `bodies` brings tables and waves
together, for all bodies. Start reading in `recording`.
"""
