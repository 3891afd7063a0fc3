"""What people look at: progress, summaries, figures.

Imports everything below it. Start with `summaries`, then `figures`; `panels` says what is shown.
"""

from m4e_fmi.report.figures import plot_run, plot_simulation
from m4e_fmi.report.files import write_simulation
from m4e_fmi.report.fmu_text import fmu_text
from m4e_fmi.report.linear_text import linear_json, linear_text
from m4e_fmi.report.progress import progress_bar
from m4e_fmi.report.summaries import run_summary, simulation_summary

__all__ = [
    "fmu_text",
    "linear_json",
    "linear_text",
    "plot_run",
    "plot_simulation",
    "progress_bar",
    "run_summary",
    "simulation_summary",
    "write_simulation",
]
