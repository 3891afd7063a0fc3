"""Connections that seem to be missing.

`loose_ends` are inputs, components and calculated parameters that are connected to nothing;
`matching_connectors` finds the connectors that would fit; `neutral_mass` is about bodies that take
their mass from another component.
"""
