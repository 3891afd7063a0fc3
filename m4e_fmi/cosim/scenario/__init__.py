"""Scenarios: actions on the signals and parameters of a system while it runs.

An action on a signal changes what its takers are given: factor and offset of their inputs
(`InputScales`), between the steps. So everything that an algorithm does with the source stays as it
is, and a signal on which no action acts keeps its bits. `plan` makes actions of what the user has
written, `scenario` lets them act at a communication point of a network. Imports the system and its
connections; start reading at `scenario`.
"""
