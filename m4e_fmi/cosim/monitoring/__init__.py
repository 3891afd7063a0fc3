"""Checks during a run: growth without bound, floating bodies, undeclared dependencies."""
