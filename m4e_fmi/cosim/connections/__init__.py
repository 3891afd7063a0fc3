"""The connections of a system, from their texts to a `Prepared` system.

`links` defines a connection between two variables, `connect` makes them of the texts; `link_checks`
and `added_mass` find what is wrong with them, `missing` what seems to be left out. `structure`
finds the order of exchange; `prepared` reports on the result. Start reading at `links` and
`connect`.
"""
