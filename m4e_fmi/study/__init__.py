"""Studies: many runs of a system or a model, and statistics of them in one labelled file.

    study.yaml ──load──► Study ──plan──► Plan (tasks, one a run) ──execution──► records ──► dataset

Start reading at `sections` (what a study file says), then `axes` (what is varied), `targets` (what
the names stand for), `plan` and `task` (one run, wherever it is made). `store` keeps runs that are
done. It may import everything but `cli`.
"""

from m4e_fmi.study.study import Study, load_study

__all__ = ["Study", "load_study"]
