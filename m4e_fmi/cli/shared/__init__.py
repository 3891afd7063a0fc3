"""Options and their values, printing, and the report of a defect: shared by the commands."""
