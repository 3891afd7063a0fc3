"""Mesh files: their kinds and panels (`mesh_files`), one module for each family of formats."""
