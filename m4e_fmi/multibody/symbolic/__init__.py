"""The equations of motion as SymPy expressions: text, LaTeX, code."""
