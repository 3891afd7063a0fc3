"""Rows of a coupled run: blocks in memory, and the writer to disk; files: m4e_fmi/results."""
