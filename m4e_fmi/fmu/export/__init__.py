"""Building FMUs: native ones, and Python ones by PythonFMU."""
