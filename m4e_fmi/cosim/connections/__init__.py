"""From connection texts to pairs of variables: types, units, buses, dependencies, loops, delays."""
