"""The parts that coupling algorithms are made of, and the choice of the step size.

`algorithm.py` is the interface of an algorithm, and the base of those that perform the same
operations in every step. Several share predicted values, and the components' steps in pieces
(`pieces.py`), with inputs that follow a parabola (`input_interpolation.py`). Adaptive steps:
`step_control.py`; jumps at which steps end: `time_events.py`.
"""
