"""Models in space as pictures: bodies in their shapes, or as boxes, with sticks to their joints.

`hulls` has the surface of each body, `solids` has a model in numbers, `pictures` projects and draws
it.
"""
