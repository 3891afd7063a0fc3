"""Forces, moments and added masses among the links: power bonds, sums of several on one body.

`bonds` finds the velocities that forces work on; `sums` tells which inputs take several sources.
"""
