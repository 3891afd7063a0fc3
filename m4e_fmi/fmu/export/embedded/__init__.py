"""Modules that travel inside FMUs. They import the standard library, pythonfmu and one another."""
