"""Connections that seem to be missing.

`loose_ends` are inputs and components that are connected to nothing; `matching_connectors` finds
the connectors that would fit; `unconnected_parameters` and `neutral_mass` are about parameters that
another component calculates.
"""
