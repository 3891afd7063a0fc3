"""The radiation memory: coefficients over frequency become a passive state space.

`soundness` checks the data, `reach` chooses the frequencies, `group_fit` fits a group of motions to
its data by `vector_fitting` and `passivity`. Start reading in `radiation`.
"""
