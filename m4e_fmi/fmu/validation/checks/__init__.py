"""The groups of checks that run the code of an FMU, one module each."""
