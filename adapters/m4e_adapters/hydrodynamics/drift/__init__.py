"""Second-order drift: slowly varying forces of the differences of wave frequencies.

`tables` has the data, `wamit_files` and `files` read them, `far_field` computes a table for a hull.
`factors` makes sums over pairs of waves sums over waves, which `recording` records; `matching`
brings tables and waves together, for all bodies in `bodies`. Start reading in `recording`.
"""
