"""Models in space as pictures: bodies in their shapes, or as boxes, with sticks to their joints.

`hulls` has the surface of each body, `hinges` the joints, `solids` a model in numbers, which
`pictures` projects and draws, and `modes` in the shapes of its modes.
"""
