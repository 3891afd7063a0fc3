"""Random systems of components that are all equations: carts with pendulums, coupled to each other.

Carts push each other by springs across the connections, in a ring; a power take-off acts on a
pendulum's tip, a controller on a joint, a table on a cart.
"""

from __future__ import annotations

import random
from pathlib import Path

from m4e_fmi.cosim import System, load_system

ALGORITHMS = ("jacobi", "gauss_seidel", "corrector", "implicit")
MODEL = """\
name: {name}
gravity: 9.81
parameters:
  k: {{value: {stiffness:.6g}, unit: N/m}}
  c: {{value: {damping:.6g}, unit: N.s/m}}
bodies:
  cart: {{mass: {cart:.6g}, inertia: 1}}
  bob: {{mass: {bob:.6g}, inertia: {inertia:.6g}}}
joints:
  rail: {{type: prismatic, child: cart, direction: [1, 0], initial: {{q: {q:.6g}}}}}
  hinge: {{type: revolute, parent: cart, child: bob, joint_to_child: [0, -{length:.6g}],
    initial: {{q: {angle:.6g}}}}}
loads:
  spring: {{type: joint_effort, joint: rail, effort: -k*joint.rail.q - c*joint.rail.u}}
points:
  tip: {{body: bob, at: [0, -0.1]}}
"""


def cart_system(folder: Path, seed: int) -> System:
    """The system of a seed; its files are written to `folder`."""
    r = random.Random(seed)
    count = r.randint(2, 4)
    names = [f"m{k}" for k in range(count)]
    for name in names:
        text = MODEL.format(
            name=name,
            stiffness=r.uniform(20, 200),
            damping=r.uniform(0, 5),
            cart=r.uniform(1, 5),
            bob=r.uniform(0.5, 2),
            inertia=r.uniform(0.05, 0.2),
            q=r.uniform(-0.2, 0.2),
            length=r.uniform(0.3, 1.0),
            angle=r.uniform(-0.5, 0.5),
        )
        (folder / f"{name}.model.yaml").write_text(text, encoding="utf-8")
    components = [f"  {name}: {{model: {name}.model.yaml}}" for name in names]
    connections = []
    for a, b in zip(names, [*names[1:], names[0]], strict=True):
        stiffness = r.uniform(5, 40)
        connections.append(
            f"{a}.joint.rail.q * -{stiffness:.6g} -> {b}.joint.rail.effort, units ignored"
        )
    if r.random() < 0.7:
        components.append(
            f"  pto: {{kind: linear_pto, point: tip, anchor: [1, -2], point_at: [0, -1], "
            f"damping: {r.uniform(1, 10):.6g}, stiffness: {r.uniform(0, 20):.6g}}}"
        )
        connections.append("m0.tip <-> pto.tip")
    if r.random() < 0.7:
        components.append(
            f"  pid: {{kind: joint_pid, duration: {r.uniform(0.5, 1.5):.6g}, joints: {{hinge: "
            f"{{target: {r.uniform(-0.5, 0.5):.6g}, proportional: {r.uniform(5, 40):.6g}, "
            f"integral: {r.uniform(0, 10):.6g}, derivative: {r.uniform(0.5, 4):.6g}}}}}}}"
        )
        connections.append("m1.hinge <-> pid.hinge")
    if r.random() < 0.5:
        times = [0.3 * k for k in range(8)]
        forces = [round(r.uniform(-5, 5), 3) for _ in times]
        components.append(
            f"  push: {{kind: table, times: {times}, beyond: held, "
            f"signals: {{f: {{unit: N, values: {forces}}}}}}}"
        )
        connections.append("push.f -> m0.body.cart.force_x")
    step = r.choice((0.01, 0.02, 0.04))
    lines = [
        f"name: system{seed}",
        "components:",
        *components,
        "connections:",
        *(f"  - {text}" for text in connections),
        f"simulation: {{stop_time: 2, step_size: {step}, algorithm: {r.choice(ALGORITHMS)}}}",
    ]
    path = folder / "system.yaml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return load_system(path)
