"""The system as described by its author: components, start values, connection texts, own steps.

Start reading at `system`. `component` and `simulation` are its parts, `connection_text` the grammar
of a connection; `start_values` and `component_steps` compare them with the FMUs.
"""
