"""What the build of the documentation does beyond Sphinx; `conf.py` calls it.

`run_page` runs what a page shows, `script_page` makes pages of scripts, `api_text` prepares
docstrings, `math` writes formulas. Imports m4e_fmi.
"""
