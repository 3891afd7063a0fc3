"""The master: a whole run, or one stepped from Python, recorded and judged."""
