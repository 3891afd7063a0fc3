"""Programs that tests of the runtime share."""

from __future__ import annotations

import itertools
import operator

from m4e_fmi.program import Program, Recorder, Variable, functions
from m4e_fmi.program.binary_form import Entry
from m4e_fmi.program.functions import atan2, cos, sin
from m4e_fmi.program.tape import BINARY, UNARY, Scalar


def chain(n: int) -> Program:
    """Pendulum of n links (2 m, 10 kg each), angles from the horizontal, by recursion: O(n)."""
    r = Recorder(f"chain{n}", f"pendulum of {n} links")
    g = r.parameter(Variable("g", "m/s2", "gravity", start=9.81))
    links = range(n)
    length = [r.parameter(Variable(f"L{i}", "m", "length", start=2.0)) for i in links]
    mass = [r.parameter(Variable(f"m{i}", "kg", "mass", start=10.0)) for i in links]
    inertia = [r.parameter(Variable(f"J{i}", "kg.m2", "inertia", start=40 / 12)) for i in links]
    angle = [r.state(Variable(f"theta{i}", "rad", "angle")) for i in links]
    omega = [r.state(Variable(f"omega{i}", "rad/s", "angular velocity")) for i in links]
    xx = xz = zz = px = pz = 0.0  # force at the inner joint = (xx, xz; xz, zz) acceleration + p
    passes = []
    for i in reversed(links):
        ex, ez, tx, tz = cos(angle[i]), -sin(angle[i]), -sin(angle[i]), -cos(angle[i])
        arm, square = mass[i] * length[i] * 0.5, omega[i] * omega[i]
        bx, bz = -length[i] * square * ex, -length[i] * square * ez
        qx, qz = px + xx * bx + xz * bz, pz + xz * bx + zz * bz
        ux, uz = xx * tx + xz * tz, xz * tx + zz * tz
        total = inertia[i] + arm * length[i] * 0.5 + length[i] * length[i] * (tx * ux + tz * uz)
        kx, kz = arm * tx + length[i] * ux, arm * tz + length[i] * uz
        d = arm * tz * g + length[i] * (tx * qx + tz * qz)
        gx, gz, free = kx / total, kz / total, d / total
        passes.append((gx, gz, free, tx, tz, bx, bz))
        px = qx - arm * square * ex - kx * free
        pz = qz - arm * square * ez + mass[i] * g - kz * free
        xx, xz, zz = mass[i] + xx - gx * kx, xz - gx * kz, mass[i] + zz - gz * kz
    ax = az = 0.0
    for i, (gx, gz, free, tx, tz, bx, bz) in enumerate(reversed(passes)):
        alpha = -(gx * ax + gz * az) - free
        r.rate(f"theta{i}", omega[i])
        r.rate(f"omega{i}", alpha)
        ax, az = ax + length[i] * alpha * tx + bx, az + length[i] * alpha * tz + bz
    return r.program()


def every_operation() -> Program:
    """One state, parameter and input; every operation of the tape, defined near the starts."""
    r = Recorder("every", "every operation, mit Umlaut ü")
    x = r.state(Variable("x", "m", "state", start=0.3))
    q = r.parameter(Variable("q", "m", "parameter", start=0.7, tunable=True))
    w = r.input(Variable("w", "N", "input", start=0.2, display_unit="kN"))
    for name in UNARY:
        argument = x * q - w * 0.1
        plain = {"neg": lambda a: -a, "abs": abs}
        value = plain[name](argument) if name in plain else getattr(functions, name)(argument)
        r.output(Variable(f"unary.{name}", "1", name, local=True), value)
    for name in BINARY:
        r.output(Variable(f"binary.{name}", "1", name), (x + q).record(name, w + r.time))
    r.rate("x", sin(x * q) - w * cos(x) + r.time * q**2)
    r.calculate(Variable("c", "m2", "calculated"), q * q + sin(q))
    return r.program()


def waves(count: int = 40) -> Program:
    """Two oscillators under waves that begin with other phases at t = -0.0 than at t = 0.0.

    So many components that the forces, which depend on time and parameters, are computed apart.
    """
    r = Recorder(f"waves{count}", "oscillators under forces of many frequencies")
    height = r.parameter(Variable("height", "m", "of every component", start=0.05, tunable=True))
    push = r.input(Variable("push", "N", "force", start=0.1))
    x, v, y = (r.state(Variable(name, "1", "state", start=0.2)) for name in "xvy")
    elevation = forces = r.tape.constant(0.0)
    turn = atan2(r.time, r.tape.constant(-1.0))
    for k in range(1, count + 1):
        phase = (0.3 + 0.05 * k) * r.time + (1.7 * k * k + 0.25 * turn)
        elevation = elevation + height * cos(phase)
        forces = forces + height * (cos(phase) / k - 0.3 * sin(phase))
    r.rate("x", v)
    r.rate("v", forces + push - 2.0 * x - 0.3 * v * abs(v))
    r.rate("y", forces * x - y)
    r.output(Variable("elevation", "m", "of the water"), elevation)
    r.output(Variable("force", "N", "of the waves"), forces)
    r.output(Variable("power", "W", "of the waves"), forces * v)
    r.calculate(Variable("most", "m", "possible elevation"), count * height)
    return r.program()


def every_fusion() -> Program:
    """Sums, differences and products within others, in all orders: what the interpreter may do in
    one instruction. Each is of states of its own, so that nothing else reads its parts.
    """
    r = Recorder("every_fusion", "operations within operations")
    ring = (operator.add, operator.sub, operator.mul)
    number = itertools.count()

    def some() -> Scalar:
        name = f"x{next(number)}"
        x = r.state(Variable(name, "1", "number", start=1.0))
        r.rate(name, -x)
        return x

    values = []
    for outer, inner in itertools.product(ring, repeat=2):
        values += [outer(inner(some(), some()), some()), outer(some(), inner(some(), some()))]
    for outer, first, second in itertools.product(ring, repeat=3):
        values.append(outer(first(some(), some()), second(some(), some())))
    for outer, inner in itertools.product(ring[:2], repeat=2):
        values.append(outer(inner(some(), some() * some()), some() * some()))
        values.append(outer(some() * some(), inner(some(), some() * some())))
        values.append(outer(inner(some() * some(), some()), some() * some()))
    long = some()
    for operation in 3 * ring:
        long = operation(long, some() * (some() - some()))
    for k, value in enumerate([*values, long]):
        r.output(Variable(f"y{k}", "1", "result"), value)
    return r.program()


def exact() -> Program:
    """x = exp(sin t), y = 1/(1 + t): x' = x cos t, y' = −y²; `late` = t − 0.5."""
    r = Recorder("exact", "with a known solution")
    x = r.state(Variable("x", "1", "exp(sin t)", start=1.0))
    y = r.state(Variable("y", "1", "1/(1 + t)", start=1.0))
    r.rate("x", x * cos(r.time))
    r.rate("y", -y * y)
    r.output(Variable("late", "s", "time beyond 0.5 s"), r.time - 0.5)
    return r.program()


def van_der_pol(mu: float) -> tuple[Program, list[Entry]]:
    """x'' = mu (1 − x²) x' − x from (2, 0), and its Jacobian."""
    r = Recorder("van_der_pol", "relaxation oscillator")
    x = r.state(Variable("x", "1", "position", start=2.0))
    y = r.state(Variable("y", "1", "velocity"))
    r.rate("x", y)
    r.rate("y", mu * (1 - x * x) * y - x)
    entries = [(0, 1, r.tape.constant(1.0)), (1, 0, -2 * mu * x * y - 1), (1, 1, mu * (1 - x * x))]
    return r.program(), [(i, j, value.index) for i, j, value in entries]


def robertson() -> tuple[Program, list[Entry]]:
    """Robertson's chemical kinetics, and its Jacobian."""
    r = Recorder("robertson", "three species")
    a, b, c = (
        r.state(Variable(name, "1", "share", start=start))
        for name, start in (("a", 1.0), ("b", 0.0), ("c", 0.0))
    )
    first, second, third = 0.04 * a, 1e4 * b * c, 3e7 * b * b
    r.rate("a", -first + second)
    r.rate("b", first - second - third)
    r.rate("c", third)
    constant = r.tape.constant
    entries = [
        (0, 0, constant(-0.04)), (0, 1, 1e4 * c), (0, 2, 1e4 * b),
        (1, 0, constant(0.04)), (1, 1, -1e4 * c - 6e7 * b), (1, 2, -1e4 * b),
        (2, 1, 6e7 * b),
    ]  # fmt: skip
    return r.program(), [(i, j, value.index) for i, j, value in entries]
