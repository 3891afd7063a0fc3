"""MoorDyn input files written by others: read, checked, attached to fairleads."""
