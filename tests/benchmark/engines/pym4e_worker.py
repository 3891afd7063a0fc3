"""pyM4E in an environment of its own: reads JSON lines from stdin, answers on stdout.

Runs alone, without the rest of the benchmark: standard library, NumPy, SymPy and pyM4E only.
"""

import json
import os
import resource
import sys
import time
from pathlib import Path


def memory() -> float:
    """Peak resident memory of this process so far [bytes]."""
    status = Path("/proc/self/status")  # getrusage counts what the parent had when it forked, too
    if status.exists():
        lines = status.read_text("utf-8").splitlines()
        return 1024 * float(next(line for line in lines if line.startswith("VmHWM")).split()[1])
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def rest() -> float:
    """Resident memory of this process now [bytes]; from here on, where the system can, `memory`
    gives the peak of what follows."""
    status, reset = Path("/proc/self/status"), Path("/proc/self/clear_refs")
    if not reset.exists():
        return memory()
    reset.write_text("5", "utf-8")
    lines = status.read_text("utf-8").splitlines()
    return 1024 * float(next(line for line in lines if line.startswith("VmRSS")).split()[1])


class Worker:
    """One system in pyM4E; `system` is systems.System as plain JSON."""

    def __init__(self) -> None:
        import multibody
        import numpy
        import sympy

        self.np, self.sympy, self.multibody = numpy, sympy, multibody
        self.imports_memory = memory()

    def prepare(self, system: dict) -> dict:
        np, links = self.np, system["links"]
        began = time.process_time()
        count = len(links)
        points, forces = _loads(system)
        state = np.array([*system["q"], *system["u"]], dtype=float)
        self.system = self.multibody.MbdSystem(
            joints=[[link["parent"] + 1, k + 1] for k, link in enumerate(links)],
            types=["R" if link["revolute"] else "P" for link in links],
            parent_cg_to_joint=[link["parent_to_joint"] for link in links],
            joint_to_child_cg=[link["joint_to_child"] for link in links],
            prismatic_direction=[
                [np.nan, np.nan] if link["revolute"] else link["direction"] for link in links
            ],
            Initial_Points=points,
            Force=forces,
            g=system["gravity"],
            gVec=np.ones((count, 1)),
            ic=state,
        )
        self.masses = np.array([link["mass"] for link in links], dtype=float)
        self.inertias = np.array([link["inertia"] for link in links], dtype=float)
        self.variables = state.copy()
        self.system.t_update = []
        self.state = state
        return {
            "preparation": time.process_time() - began,
            "memory": memory() - self.imports_memory,
        }

    def spiderfloat(self) -> dict:
        """The paper's section 4.2.3 as its lists, forces held at their amplitude."""
        np, none = self.np, [self.np.nan, self.np.nan]
        began = time.process_time()
        self.state = np.array([10, 6] + [0] * 16, dtype=float)
        self.system = self.multibody.MbdSystem(
            joints=[[0, 1], [1, 2], [1, 3], [2, 4], [3, 5], [4, 6], [5, 7]],
            types=list("FRRPPRR"),
            parent_cg_to_joint=[
                [10, 6], [0.5, -2], [-0.5, -2], [4.5, 0], [-4.5, 0], [0, 0], [0, 0]
            ],
            joint_to_child_cg=[
                none, [5, 0], [-5, 0], [0.5, 0], [-0.5, 0], [0, 1.5], [0, 1.5]
            ],
            prismatic_direction=[none, none, none, [1, 0], [1, 0], none, none],
            Initial_Points={
                "GR": [[20, 0], [0, 0]],
                "BD": {
                    1: [[0.5, -2.5], [-0.5, -2.5], [0.5, 5], [-0.5, 5]],
                    2: [[4, 0], [4.5, 0]],
                    3: [[-4, 0], [-4.5, 0]],
                },
            },
            Force={
                "PointsBD": [],
                "CG": [[1, 0, 1, 0], [4, 1, 0, 0], [5, -1, 0, 0]],
                "TensionSpring": [
                    (("BD1_0", "BD2_0"), [9.0139, 0.1]),
                    (("BD1_1", "BD3_0"), [9.0139, 0.1]),
                    (("BD1_2", "BD2_1"), [11.8004, 0.1]),
                    (("BD1_3", "BD3_1"), [11.8004, 0.1]),
                    (("BD2_0", "GR0_0"), [3.0414, 0.1]),
                    (("GR0_1", "BD3_0"), [3.0414, 0.1]),
                ],
                "TensionDamper": [(("GR0_0", "CG2_0"), 3.0), (("GR0_1", "CG3_0"), 3.0)],
                "TorsionSpring": [((1, 2), [0, 100.0]), ((1, 3), [0, 100.0])],
                "TorsionDamper": [((1, 2), 10.0), ((1, 3), 10.0)],
            },
            g=0.0,
            gVec=np.ones((7, 1)),
            ic=self.state,
        )  # fmt: skip
        self.masses, self.inertias = np.ones(7), 2.0 * np.ones(7)
        self.variables = self.state.copy()
        self.system.t_update = []
        return {"preparation": time.process_time() - began}

    def rates(self, state):
        return self.multibody.integrate_dynamics(
            0.0, state, self.variables, self.masses, self.inertias, self.system
        )

    def accelerations(self, q: list, u: list) -> list:
        return self.rates(self.np.array([*q, *u], dtype=float))[len(q) :].tolist()

    def batch(self, calls: int) -> float:
        began = time.process_time()
        for _ in range(calls):
            self.rates(self.state)
        return time.process_time() - began

    def integrate(self, stop_time: float, interval: float) -> dict:
        began = time.process_time()
        solution = self.system.integrate(
            self.variables,
            self.masses,
            self.inertias,
            tspan=stop_time,
            dt=interval,
            rtol=1e-8,
            atol=1e-8,
            algorithm="RK45",
        )
        return {
            "seconds": time.process_time() - began,
            "evaluations": int(solution.nfev),
            "final": solution.y[:, -1].tolist(),
            "memory": memory() - self.imports_memory,
        }


def _loads(system: dict) -> tuple[dict, dict]:
    """pyM4E's points and forces; its names count bodies from 1, points from 0."""
    points: dict = {"GR": [], "BD": {}}
    forces: dict = {
        name: []
        for name in (
            "PointsBD", "CG", "TensionSpring", "TensionDamper", "TorsionSpring", "TorsionDamper",
        )
    }  # fmt: skip

    def point(link: int, at: list) -> str:
        if link < 0:
            points["GR"].append(at)
            return f"GR0_{len(points['GR']) - 1}"
        mine = points["BD"].setdefault(link + 1, [])
        mine.append(at)
        return f"BD{link + 1}_{len(mine) - 1}"

    for s in system["springs"]:
        ends = point(s["first"], s["first_point"]), point(s["second"], s["second_point"])
        forces["TensionSpring"].append((ends, [s["length"], s["stiffness"]]))
        forces["TensionDamper"].append((ends, s["damping"]))
    for t in system["torsions"]:
        pair = (t["against"] + 1, t["link"] + 1)
        forces["TorsionSpring"].append((pair, [t["angle"], t["stiffness"]]))
        forces["TorsionDamper"].append((pair, t["damping"]))
    return points, forces


def main() -> None:
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what pyM4E prints does not belong among the answers
    worker = None
    for line in sys.stdin:
        try:
            worker = worker or Worker()
            request = json.loads(line)
            answer = {"value": getattr(worker, request["do"])(*request["with"])}
        except Exception as error:  # noqa: BLE001 - whatever pyM4E raises is an answer, too
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
