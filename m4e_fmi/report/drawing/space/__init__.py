"""Models in space as pictures: boxes with the bodies' inertias, sticks to their joints and points.

`solids` has a model in numbers, `views` projects it, `pictures` draws it.
"""
