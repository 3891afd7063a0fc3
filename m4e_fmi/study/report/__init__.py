"""Reports of studies: one HTML page with all numbers, from the result file alone.

Start with `of_study`, which takes results of runs, too. `record` is what results carry for it,
`result` reads them, `summary` and `annual` are its texts, `content` the numbers for its scripts:
`dims.js` has them, `maps.js`, `scatter.js`, `numbers.js` and `runs.js` show them. All that any
interactive page needs is in `m4e_fmi/report/web`. It may import `m4e_fmi/study/given` and
`m4e_fmi/study/shown`, not `run`.
"""
