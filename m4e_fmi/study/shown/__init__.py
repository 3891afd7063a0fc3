"""Studies for people: summary, pictures, progress."""
