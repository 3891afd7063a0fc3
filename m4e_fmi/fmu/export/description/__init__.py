"""The model description of an FMU that is built: FMI 2.0 and 3.0, arrays, terminals."""
