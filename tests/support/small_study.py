"""A small system for studies, a cart with a pendulum and a power take-off, and an executor here."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import ParamSpec, TypeVar

Given = ParamSpec("Given")
Result = TypeVar("Result")

MODEL = """\
name: cart
gravity: 9.81
parameters:
  k: {value: 40, unit: N/m, description: Stiffness of the spring}
bodies:
  cart: {mass: 2, inertia: 1}
  bob: {mass: 1, inertia: 0.1}
joints:
  rail: {type: prismatic, child: cart, direction: [1, 0], initial: {q: 0.2}}
  hinge: {type: revolute, parent: cart, child: bob, joint_to_child: [0, -0.5], initial: {q: 0.3}}
loads:
  spring: {type: joint_effort, joint: rail, effort: -k*joint.rail.q}
points:
  tip: {body: bob, at: [0, -0.1]}
"""
SYSTEM = """\
name: carts
components:
  cart: {model: cart.model.yaml}
  pto: {kind: linear_pto, point: tip, anchor: [1, -2], point_at: [0, -1], damping: 4, stiffness: 5}
  push:
    kind: table
    times: [0, 1, 2]
    beyond: held
    signals: {f: {unit: N, values: [0, 1, 0]}}
connections:
  - cart.tip <-> pto.tip
  - push.f -> cart.body.cart.force_x
simulation: {stop_time: 1, step_size: 0.02}
"""


class Here(Executor):
    """An executor that makes each call at once, in this process; `calls` counts them."""

    def __init__(self) -> None:
        self.calls = 0

    def submit(
        self, fn: Callable[Given, Result], /, *args: Given.args, **kwargs: Given.kwargs
    ) -> Future[Result]:
        """The result of the call, which is made here."""
        self.calls += 1
        future: Future[Result] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # noqa: BLE001  as executors do
            future.set_exception(error)
        return future


def written_study(folder: Path, text: str, *, system: str = SYSTEM) -> Path:
    """The file of a study; the system and its model are written beside it."""
    (folder / "cart.model.yaml").write_text(MODEL, encoding="utf-8")
    (folder / "system.yaml").write_text(system, encoding="utf-8")
    path = folder / "study.yaml"
    path.write_text(text, encoding="utf-8")
    return path
