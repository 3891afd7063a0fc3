"""The loop over macro steps: step size, jumps, energy balance of the coupling."""
