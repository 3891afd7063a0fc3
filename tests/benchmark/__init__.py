"""How fast the product is beside its peers, measured in one run: `make bench` (never a gate).

`systems` says what is simulated, `reference` what the right answer is, `engines/` has one file per
engine behind the protocol of `engine`, `timing` how time is taken. `run` measures and writes
build/benchmark.json; `report` makes docs/benchmark.md and docs/benchmark.png from it.
"""
