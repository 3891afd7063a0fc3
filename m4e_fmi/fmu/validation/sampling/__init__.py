"""Points and excitations at which an FMU is sampled, and derivatives from samples."""
