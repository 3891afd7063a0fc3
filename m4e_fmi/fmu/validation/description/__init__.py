"""Checks of the archive and the XML, before any code of the FMU runs."""
