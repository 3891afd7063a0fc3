"""Checks during a run: growth without bound, undeclared dependencies."""
