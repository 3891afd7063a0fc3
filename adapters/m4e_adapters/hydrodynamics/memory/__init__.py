"""Radiation memory: a passive state-space fit of the radiation force, and its accuracy."""
