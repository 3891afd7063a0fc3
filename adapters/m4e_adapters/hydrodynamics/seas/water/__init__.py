"""Motion of the water: kinematics of waves, currents, recorded and in plain arrays."""
