"""A mass in the plane, with the names that bodies have."""

from __future__ import annotations

from m4e_fmi.program import Program, Recorder, Variable, sin, sqrt


def plane() -> Program:
    """a = (gain·force + a moving wind)/mass − stiffness·position; states in the order x, vx, z, vz.

    `gain[i,j]` is a matrix whose elements differ in their unit; the wind blows with time.
    """
    r = Recorder("plane", "a mass in the plane")
    mass = r.parameter(Variable("mass", "kg", "mass", start=2.0))
    stiffness = r.parameter(Variable("stiffness", "1/s2", "of both springs", start=9.0))
    gain = [
        [
            r.parameter(
                Variable(
                    f"gain[{i},{j}]",
                    "1" if i == j else "rad",
                    "from forces to directions",
                    start=1.0 if i == j else 0.1 * i,
                    tunable=True,
                )
            )
            for j in (1, 2)
        ]
        for i in (1, 2)
    ]
    force = [r.input(Variable(f"body.ball.force_{a}", "N", f"pull along {a}")) for a in "xz"]
    moment = r.input(Variable("body.ball.moment_y", "N.m", "not used by the motion"))
    places, speeds = [], []
    for k, a in enumerate("xz"):
        places.append(r.state(Variable(f"body.ball.{a}", "m", f"place along {a}", start=0.3 + k)))
        speeds.append(
            r.state(
                Variable(
                    f"body.ball.v{a}", "m/s", f"speed along {a}", derivative_of=f"body.ball.{a}"
                )
            )
        )
    wind = sin(2.0 * r.time)
    for k, a in enumerate("xz"):
        push = gain[k][0] * force[0] + gain[k][1] * force[1] + (wind if k else 0.0)
        rate = push / mass - (1.0 + k) * stiffness * places[k]
        r.rate(f"body.ball.{a}", speeds[k])
        r.rate(f"body.ball.v{a}", rate)
        r.output(
            Variable(
                f"body.ball.a{a}",
                "m/s2",
                f"acceleration along {a}",
                derivative_of=f"body.ball.v{a}",
            ),
            rate,
        )
    for k, a in enumerate("xz"):
        r.output(Variable(f"joint.post.reaction_{a}", "N", f"along {a}"), mass * speeds[k] * wind)
    r.output(Variable("power", "W", "of the force"), force[0] * speeds[0] + force[1] * speeds[1])
    r.output(Variable("root", "1", "fails far to the left"), sqrt(0.5 + places[0]))
    r.output(Variable("turn", "N.m", "the moment again"), 3.0 * moment)
    r.calculate(Variable("weight", "N", "of the mass"), 9.81 * mass)
    return r.program()
