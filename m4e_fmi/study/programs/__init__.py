"""Studies of one program, a model or a composed system: `names`, then `plan` (ensembles)."""
