"""`m4e-fmi new`: the command (`starts`) and its templates.

Imports `cli/shared`. A template whose name ends in `.txt` is code that no check takes for ours.
"""

from m4e_fmi.cli.new.starts import add

__all__ = ["add"]
