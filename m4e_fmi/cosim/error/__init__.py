"""The estimate of the coupling error: a second trajectory, its courses, and the certificate.

Start reading at `estimator`. `trajectory` makes the steps, `course` has what they tell and
extrapolates it to the whole run, `roughness` watches the rest; `state` is all that is saved and
restored, and `report` makes the certificate.
"""
