"""Pictures: schematics, animations, figures of time histories, graphs of systems."""
