"""Forces, moments and added masses among the links: power bonds, sums of several on one body.

`bonds` finds the velocities that forces work on; `sums` puts components of ``kind: sum`` between
several sources and one input.
"""
