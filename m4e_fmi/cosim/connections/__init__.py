"""The connections of a system, from their texts to a `Prepared` system.

`links` defines a connection between two variables, `connect` makes them of the texts (by `pairing`,
`link_checks` and `loads/`). `dependence` and `structure` find the order of
exchange; `prepared` and `missing/` report on the result. Start reading at `links` and `connect`.
"""
