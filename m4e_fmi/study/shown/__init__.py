"""Studies for people: summary, warnings, what is told of all states."""
