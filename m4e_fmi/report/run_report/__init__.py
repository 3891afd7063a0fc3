"""Reports of runs and simulations: one HTML page with all samples, from a file of results.

Start with `of_run`. `record` is what results carry for it, `summary` has its texts,
`flows` the power between components; `run_report.js` and `flows.js` are its scripts. All that any
interactive page needs is in `m4e_fmi/report/web`.
"""
