"""Commands on results that are there already: `compare`, `decay`, `report`.

One module for each, as in `m4e_fmi/cli`, with the same `add` and `_run`.
"""
