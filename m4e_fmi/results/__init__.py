"""Results of runs and simulations: files while they grow and at the end, series."""
