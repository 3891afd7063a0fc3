"""The connections of a system, from their texts to a `Prepared` system.

`links` defines a connection between two variables, `connect` makes them from the texts;
`link_checks` and `added_mass` find errors in them, `missing` finds connections that seem to be left
out. `structure` finds the order of exchange; `prepared` reports on the result. Start reading at
`links` and `connect`.
"""
