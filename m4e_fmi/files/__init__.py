"""Files in general: YAML with line numbers, CSV columns, names, locks, safe writes."""
