"""Hulls: shapes, meshes, panels, hydrostatics."""
