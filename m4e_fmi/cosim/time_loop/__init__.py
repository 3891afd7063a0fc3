"""The loop over macro steps: step size, events in time, jumps, energy balance of the coupling."""
