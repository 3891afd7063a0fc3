"""Objects as notebooks show them: HTML, figures, animations. Start with `views`.

It imports everything but `cli`, and nothing imports it: `m4e_fmi/__init__.py` tells `m4e_fmi.shown`
where it is, and the objects ask there.
"""

from m4e_fmi.notebook.views import animation, figure, html

__all__ = ["animation", "figure", "html"]
