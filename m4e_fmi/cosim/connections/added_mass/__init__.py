"""Added mass of bodies in water: the bodies of each matrix, their order, bodies without it.

A matrix ``added_mass`` has rows and columns per body: a hydrodynamics component's in the order of
its file, a model's in the order of its body numbers. `matrices` reads the bodies, `order` compares
those of a connection, `left_out` finds bodies in water whose model has no added mass.
"""
