"""From a system to one that can run: FMUs built and read, dependencies probed, the overview."""
