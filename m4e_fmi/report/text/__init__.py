"""Reports as text: summaries, tables, validation, linear equations."""
