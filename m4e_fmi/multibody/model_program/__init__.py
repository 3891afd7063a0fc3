"""A model as a Program: its variables, outputs, and mass matrix."""
