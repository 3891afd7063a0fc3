"""Charts of results over time, in groups: start with `difference_figure`."""
