"""Second-order drift: slowly varying forces of the differences of wave frequencies.

`tables` has the data, `mean_files` and `qtf_files` read them, `far_field` computes a table for a
hull. `factors` makes sums over pairs of waves sums over waves. Start
reading in `recording`.
"""
