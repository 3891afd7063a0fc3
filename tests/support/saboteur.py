"""A component that stands between two others and does to its signal what an action does.

It is written independently of m4e_fmi's scenarios: a Python FMU with the input u, the output y, and
the time of its next jump.
"""

from __future__ import annotations

import json
from pathlib import Path

from m4e_fmi.fmu import FmuVariable, ModelDescription, PythonSource, build_fmu

SLAVE = '''\
"""Passes u on as y, or spoils it from `begin` to `end` (ns)."""
import json
from hashlib import blake2b
from math import cos, log, pi, sqrt

from .slave_base import M4eSlave


class Saboteur(M4eSlave):
    def initialise(self):
        text = (self.resources / "saboteur.json").read_text(encoding="utf-8")
        self.given = json.loads(text)
        self.history = []
        self.frozen = self.last = None

    def step(self, t, h):
        now, u = round(1e9 * t), self.values[self.index["u"]]
        if self._active(now) and self.frozen is None:
            self.frozen = u
        if not (self._active(now) and self.given["kind"] == "dropout" and self._lost(now)):
            self.last = u
        self.history.append((now, u))

    def _active(self, now):
        return self.given["begin"] <= now < self.given["end"]

    def _drawn(self, now):
        index = (now - self.given["begin"]) // self.given["every"]
        text = "{} {} {}".format(self.given["seed"], index, self.given["signal"])
        digest = blake2b(text.encode(), digest_size=16).digest()
        parts = int.from_bytes(digest[:8], "little"), int.from_bytes(digest[8:], "little")
        return [((part >> 11) + 0.5) / 2**53 for part in parts]

    def _lost(self, now):
        return self._drawn(now)[0] <= self.given["amount"]

    def update(self):
        now, u = round(1e9 * self.time), self.values[self.index["u"]]
        y = getattr(self, "_" + self.given["kind"])(now, u) if self._active(now) else u
        self.values[self.index["y"]] = y
        begin, end = self.given["begin"], self.given["end"]
        self.values[self.index["next_event_time"]] = self._next(now, begin, end) / 1e9

    def _next(self, now, begin, end):
        if now < begin or self.given["kind"] not in ("noise", "dropout"):
            return begin if now < begin else end
        every = self.given["every"]
        return min(end, begin + ((now - begin) // every + 1) * every)

    def _freeze(self, now, u):
        return u if self.frozen is None else self.frozen

    def _offset(self, now, u):
        return u + self.given["amount"]

    def _replace(self, now, u):
        return self.given["amount"]

    def _noise(self, now, u):
        first, second = self._drawn(now)
        return u + self.given["amount"] * (sqrt(-2 * log(first)) * cos(2 * pi * second))

    def _dropout(self, now, u):
        return self.last if self._lost(now) else u

    def _delay(self, now, u):
        wanted = now - round(1e9 * self.given["amount"])
        points = [*self.history, (now, u)]
        for (t, y), (later, z) in zip(points, points[1:]):
            if t <= wanted < later:
                return y if t == wanted else y + (z - y) * ((wanted - t) / (later - t))
        return points[0][1]

    def _ramp(self, now, u):
        share = min(1.0, (now - self.given["begin"]) / self.given["every"])
        return self.given["amount"] if share == 1.0 else u + (self.given["amount"] - u) * share

    def save(self):
        return {"history": self.history, "frozen": self.frozen, "last": self.last}

    def restore(self, saved):
        self.history = [tuple(point) for point in saved["history"]]
        self.frozen, self.last = saved["frozen"], saved["last"]
'''


def saboteur(
    folder: Path,
    kind: str,
    *,
    begin: float,
    end: float,
    amount: float = 0.0,
    every: float = 1.0,
    seed: int = 0,
    signal: str = "",
    unit: str = "m/s",
) -> Path:
    """The FMU, in a `folder`, that acts from `begin` to `end` [s].

    `amount` and `every` [s] are those of the action; `signal` is the name that it has there, `unit`
    its unit.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "saboteur.py").write_text(SLAVE, encoding="utf-8")
    given = {"kind": kind, "begin": round(1e9 * begin), "end": round(1e9 * end), "amount": amount}
    given |= {"every": round(1e9 * every), "seed": seed, "signal": signal}
    variables = (
        FmuVariable("u", unit, "the signal", "input", start=0.0),
        FmuVariable("y", unit, "what is given on", "output", "continuous", "calculated",
                    dependencies=("u",), initial_dependencies=("u",)),
        FmuVariable("next_event_time", "s", "the next jump", "local", "continuous", "calculated"),
    )  # fmt: skip
    source = PythonSource(
        ModelDescription("saboteur", "spoils a signal", variables),
        "saboteur:Saboteur",
        {"saboteur.py": folder / "saboteur.py"},
        {"saboteur.json": json.dumps(given).encode()},
    )
    return build_fmu(source, folder / "saboteur.fmu")
