"""Running FMU instances and the values exchanged between them, by operations in C or Python."""
