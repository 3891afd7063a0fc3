"""A study as given: the sections of its file, its dimensions, tables of cases. See `sections`."""
