"""Studies: many runs of a system or a model, and statistics of them in one labelled file.

    study.yaml ── study ──► Study ── work ──► keys, tasks ── execution ──► records ──► dataset

Start reading at `given/` (what a study file says), then `names` and `targets` (what its names stand
for), the plans of `systems/` (FMUs, tasks) and `programs/` (ensembles), `record` (what is kept of
each run) and `run`; `report/` is the page of a result. The package itself can be called as
`run_study` is: ``m4e_fmi.study("study.yaml", …)``. It may import everything but `cli`.
"""

from m4e_fmi.lazy import as_verb
from m4e_fmi.study.given.study import Study, load_study
from m4e_fmi.study.report.of_study import report_of_study, write_report
from m4e_fmi.study.run import StudyOutcome, run_study

study = run_study

__all__ = [
    "Study",
    "StudyOutcome",
    "load_study",
    "report_of_study",
    "run_study",
    "study",
    "write_report",
]

__doc__ = run_study.__doc__


as_verb(__name__, run_study)
