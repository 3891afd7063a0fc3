"""Output for people: progress, summaries, tables, figures, drawings, animations.

Imports everything below it. Start with `summaries`, then `figures`; `panels` says what is shown.
Pictures and animations start from a `scene`, painted by `views`; `parts`, `hulls`
give outlines, `style` the colours. Reports: `run_report`, of the parts in `web`.
"""

from typing import TYPE_CHECKING

from m4e_fmi.lazy import lazy

if TYPE_CHECKING:
    from m4e_fmi.report.animation.results_page import animate, animate_run
    from m4e_fmi.report.data_files import write_hydro, write_sea, write_waves
    from m4e_fmi.report.drawing.figures import plot_run, plot_simulation
    from m4e_fmi.report.drawing.mooring_figures import plot_lines, plot_mooring
    from m4e_fmi.report.drawing.record_figures import plot_decay, plot_differences
    from m4e_fmi.report.drawing.schematic import draw_model, model_figure
    from m4e_fmi.report.drawing.style import check_picture_path
    from m4e_fmi.report.drawing.system_graph import draw_system, system_figure
    from m4e_fmi.report.drawing.wave_figures import plot_hydro, plot_waves
    from m4e_fmi.report.files import write_simulation
    from m4e_fmi.report.page.fmu_documentation import fmu_documentation, whole_documentation
    from m4e_fmi.report.progress import progress_bar, runs_bar, say_beside
    from m4e_fmi.report.run_report.of_run import report_of_run
    from m4e_fmi.report.text.fmu_text import fmu_text, validation_text
    from m4e_fmi.report.text.point_text import (
        equilibrium_text,
        equilibrium_values,
        linear_json,
        linear_text,
    )
    from m4e_fmi.report.text.record_text import (
        decay_json,
        decay_text,
        difference_json,
        difference_text,
    )
    from m4e_fmi.report.text.summaries import (
        run_numbers,
        run_summary,
        run_text,
        simulation_numbers,
        simulation_summary,
        simulation_text,
    )
    from m4e_fmi.report.text.tables import model_tables
    from m4e_fmi.report.text.wave_text import (
        hydro_json,
        hydro_text,
        sea_json,
        sea_text,
        wave_json,
        wave_text,
    )

__all__ = [
    "animate",
    "animate_run",
    "check_picture_path",
    "decay_json",
    "decay_text",
    "difference_json",
    "difference_text",
    "draw_model",
    "draw_system",
    "equilibrium_text",
    "equilibrium_values",
    "fmu_documentation",
    "fmu_text",
    "hydro_json",
    "hydro_text",
    "linear_json",
    "linear_text",
    "model_figure",
    "model_tables",
    "plot_decay",
    "plot_differences",
    "plot_hydro",
    "plot_lines",
    "plot_mooring",
    "plot_run",
    "plot_simulation",
    "plot_waves",
    "progress_bar",
    "report_of_run",
    "run_numbers",
    "run_summary",
    "run_text",
    "runs_bar",
    "say_beside",
    "sea_json",
    "sea_text",
    "simulation_numbers",
    "simulation_summary",
    "simulation_text",
    "system_figure",
    "validation_text",
    "wave_json",
    "wave_text",
    "whole_documentation",
    "write_hydro",
    "write_sea",
    "write_simulation",
    "write_waves",
]

_MODULES = {
    "animation.results_page": ("animate", "animate_run"),
    "data_files": (
        "write_hydro",
        "write_sea",
        "write_waves",
    ),
    "drawing.figures": (
        "plot_run",
        "plot_simulation",
    ),
    "drawing.record_figures": (
        "plot_decay",
        "plot_differences",
    ),
    "drawing.mooring_figures": (
        "plot_lines",
        "plot_mooring",
    ),
    "drawing.schematic": (
        "draw_model",
        "model_figure",
    ),
    "drawing.style": ("check_picture_path",),
    "drawing.system_graph": (
        "draw_system",
        "system_figure",
    ),
    "drawing.wave_figures": (
        "plot_hydro",
        "plot_waves",
    ),
    "files": ("write_simulation",),
    "page.fmu_documentation": (
        "fmu_documentation",
        "whole_documentation",
    ),
    "progress": (
        "progress_bar",
        "runs_bar",
        "say_beside",
    ),
    "run_report.of_run": ("report_of_run",),
    "text.fmu_text": (
        "fmu_text",
        "validation_text",
    ),
    "text.point_text": (
        "equilibrium_text",
        "equilibrium_values",
        "linear_json",
        "linear_text",
    ),
    "text.record_text": (
        "decay_json",
        "decay_text",
        "difference_json",
        "difference_text",
    ),
    "text.summaries": (
        "run_numbers",
        "run_summary",
        "run_text",
        "simulation_numbers",
        "simulation_summary",
        "simulation_text",
    ),
    "text.tables": ("model_tables",),
    "text.wave_text": (
        "hydro_json",
        "hydro_text",
        "sea_json",
        "sea_text",
        "wave_json",
        "wave_text",
    ),
}
__getattr__, __dir__ = lazy(__name__, _MODULES)
