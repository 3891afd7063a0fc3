"""How the documentation is built: `make docs`, then open build/docs/index.html.

Pages are Markdown (MyST). What the pages in PAGES_THAT_RUN show is run before they are read, with
its pictures in the ignored folder generated/; scripts of examples/ become pages there, too.
"""

import shutil
import sys
from pathlib import Path

DOCS = Path(__file__).parent
ROOT = DOCS.parent
sys.path.insert(0, str(DOCS))

from doc_tools.api_text import plain_docstring  # noqa: E402
from doc_tools.run_page import run_page  # noqa: E402
from doc_tools.script_page import write_script_page  # noqa: E402
from sphinx.application import Sphinx  # noqa: E402
from sphinx.config import Config  # noqa: E402

import m4e_fmi  # noqa: E402

PAGES_THAT_RUN = (
    "index",
    "tutorial",
    "exchange",
    "commands",
    "from/wec_sim",
    "from/openfast",
    "from/fmpy",
    "from/simscape",
    "model_files",
    "input",
    "other_inputs",
    "parameters",
    "pictures",
    "analysis",
    "whole_systems",
    "moorings",
    "statistics",
    "comparing",
    "programs",
    "stepping",
    "notebooks",
    "gallery/double_pendulum",
    "gallery/equations",
    "gallery/gyroscope",
    "gallery/modes",
    "gallery/decay",
    "gallery/ballast",
    "gallery/rao",
    "gallery/hydraulic_pto",
    "gallery/line",
    "gallery/fmu",
)
SCRIPTS = (
    "double_pendulum/double_pendulum.py",
    "paper_cases/spiderfloat_lists.py",
    "cart_pole/cart_pole.py",
    "tuned_mass_damper/tuned_mass_damper.py",
    "sphere_decay/published_curves.py",
    "two_flaps/two_flaps.py",
)
SLOW_SCRIPTS = ("sphere_decay/published_curves.py", "two_flaps/two_flaps.py")
"""Scripts that the tests do not run here: those of tests/verification assert their numbers."""
GENERATED = DOCS / "generated"

project = "m4e_fmi"
author = "The m4e_fmi developers"
project_copyright = "2026, the m4e_fmi developers"
version = release = m4e_fmi.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "doc_tools.math",
]
exclude_patterns = ["doc_tools", "generated/pages"]
suppress_warnings = ["ref.python"]  # two packages have a Simulation; both are linked

myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist", "html_image"]
myst_heading_anchors = 3
default_role = "code"

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_default_options = {"members": True}
python_maximum_signature_line_length = 88
add_module_names = False

html_theme = "furo"
html_math_renderer = "mathml"
html_title = "m4e_fmi"
html_static_path = ["static"]
html_css_files = ["m4e_fmi.css"]
html_copy_source = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#1f5f8b", "color-brand-content": "#1f5f8b"},
    "dark_css_variables": {"color-brand-primary": "#7fb6d9", "color-brand-content": "#7fb6d9"},
}


def generate(_: Sphinx, config: Config) -> None:
    """Run the pages and the scripts; animations go to the root of the site."""
    shutil.rmtree(GENERATED, ignore_errors=True)
    for name in PAGES_THAT_RUN:
        run_page(DOCS / f"{name}.md", GENERATED / "pages" / name)
    for name in SCRIPTS:
        run = config.slow_scripts or name not in SLOW_SCRIPTS
        write_script_page(ROOT / "examples" / name, GENERATED / "examples", run=run)
    config.html_extra_path = [str(p.relative_to(DOCS)) for p in GENERATED.rglob("*.html")]


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.add_config_value("slow_scripts", True, "env", [bool])
    app.connect("config-inited", generate)  # before Sphinx looks for the files
    app.connect("autodoc-process-docstring", plain_docstring)
