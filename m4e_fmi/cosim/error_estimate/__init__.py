"""Online estimate of the coupling error: step doubling in windows, or a shadow run."""
