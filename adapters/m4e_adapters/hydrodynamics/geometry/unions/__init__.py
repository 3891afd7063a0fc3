"""Unions of shapes and meshes: Boolean operations on solids, and even panels on what they make."""
