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

from .slave_base import M4eSlave


class Saboteur(M4eSlave):
    def initialise(self):
        text = (self.resources / "saboteur.json").read_text(encoding="utf-8")
        self.given = json.loads(text)
        self.frozen = None

    def step(self, t, h):
        now, u = round(1e9 * t), self.values[self.index["u"]]
        if self._active(now) and self.frozen is None:
            self.frozen = u

    def _active(self, now):
        return self.given["begin"] <= now < self.given["end"]

    def update(self):
        now, u = round(1e9 * self.time), self.values[self.index["u"]]
        y = getattr(self, "_" + self.given["kind"])(now, u) if self._active(now) else u
        self.values[self.index["y"]] = y
        begin, end = self.given["begin"], self.given["end"]
        self.values[self.index["next_event_time"]] = (begin if now < begin else end) / 1e9

    def _freeze(self, now, u):
        return u if self.frozen is None else self.frozen

    def _offset(self, now, u):
        return u + self.given["amount"]

    def _replace(self, now, u):
        return self.given["amount"]

    def _ramp(self, now, u):
        share = min(1.0, (now - self.given["begin"]) / self.given["every"])
        return self.given["amount"] if share == 1.0 else u + (self.given["amount"] - u) * share

    def save(self):
        return {"frozen": self.frozen}

    def restore(self, saved):
        self.frozen = saved["frozen"]
'''


def saboteur(
    folder: Path,
    kind: str,
    *,
    begin: float,
    end: float,
    amount: float = 0.0,
    every: float = 1.0,
    unit: str = "m/s",
) -> Path:
    """The FMU, in a `folder`, that acts from `begin` to `end` [s].

    `amount` and `every` [s] are those of the action, `unit` is that of the signal.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "saboteur.py").write_text(SLAVE, encoding="utf-8")
    given = {"kind": kind, "begin": round(1e9 * begin), "end": round(1e9 * end), "amount": amount}
    given["every"] = round(1e9 * every)
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
