"""The system as described by its author: components, start values, connection texts, own steps."""
