"""The connections of a system, from their texts to a `Prepared` system.

`links` defines a connection between two variables, `connect` makes them of the texts (by `pairing`,
`buses`, `link_checks` and `loads/`). `dependence`, `structure`, `loop_breaking` and `early_outputs`
find the order of exchange; `timing`, `overview` and `missing/` report on the result. Start reading
at `links` and `connect`.
"""
