"""Values that are not Real on connections: each type and version of FMI."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Network,
    Simulation,
    System,
    prepare,
    run,
    start,
)
from m4e_fmi.errors import InputError, RunError

Fmus = Callable[[str], Path]
KINDS = ("int", "bool", "enum", "text")
H = 0.1


@pytest.fixture(params=["C", "Python"])
def loop(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """The loop over steps, in C and in Python."""
    if request.param == "Python":
        monkeypatch.setattr("m4e_fmi.cosim.exchange.step_loop.library", lambda: None)


def part(c_fmu: Fmus, name: str, fmu: str, **values: Any) -> Component:
    return Component(name, FmuFile(c_fmu(fmu)), values)


def linked(names: Sequence[str], kinds: Sequence[str] = KINDS) -> tuple[str, ...]:
    """Connections of all types from each component to the next."""
    return tuple(f"{a}.y_{k} -> {b}.u_{k}" for a, b in pairwise(names) for k in kinds)


def watched(system: System, names: Sequence[str]) -> list[list[Any]]:
    """The values of variables at all points of a run."""
    found: list[list[Any]] = []

    def observe(_: float, network: Network) -> None:
        found.append([network.read(name) for name in names])

    run(system, observers=[observe])
    return found


def periods(time: float, period: float) -> int:
    return int(time / period + 1e-6) if period else 0


def put(number: int, boolean: bool, item: int, text: str, n: int) -> tuple[int, bool, int, str]:
    """Outputs of kinds.c after n periods, for these inputs."""
    return number + n, bool(boolean ^ (n & 1)), (item - 1 + n) % 3 + 1, text + (str(n) if n else "")


@pytest.mark.usefixtures("loop")
def test_values_pass_through_along_declared_dependencies(c_fmu: Fmus) -> None:
    parts = (
        part(c_fmu, "c", "3:kinds+state"),
        part(c_fmu, "b", "3:kinds+state+through"),
        part(c_fmu, "a", "kinds+state", period=0.3),
    )
    names = [f"{name}.y_{kind}" for name in "abc" for kind in KINDS]
    system = System("chain", parts, linked(("a", "b", "c")), Simulation(1.0, H))
    for k, row in enumerate(watched(system, names)):
        here, late = (put(0, False, 1, "", periods(t * H, 0.3)) for t in (k, max(k - 1, 0)))
        assert tuple(row) == (*here, *here, *late)  # b within the instant, c a step later


WIDE = {
    "int8": (-128, 127),
    "uint8": (0, 255),
    "int16": (-(2**15), 2**15 - 1),
    "uint16": (0, 2**16 - 1),
    "int32": (-(2**31), 2**31 - 1),
    "uint32": (0, 2**32 - 1),
    "int64": (-(2**63), 2**63 - 1),
    "uint64": (0, 2**64 - 1),
}


@pytest.mark.usefixtures("loop")
@pytest.mark.parametrize("end", [0, 1])
def test_integers_of_all_widths(c_fmu: Fmus, end: int) -> None:
    values = {f"u_{kind}": ends[end] for kind, ends in WIDE.items()}
    parts = (
        part(c_fmu, "a", "3:kinds+state+through", **values),
        part(c_fmu, "b", "3:kinds+state"),
    )
    links = tuple(f"a.y_{kind} -> b.u_{kind}" for kind in WIDE)
    names = [f"b.{way}_{kind}" for way in "uy" for kind in WIDE]
    found = watched(System("s", parts, links, Simulation(2 * H, H)), names)
    assert found[-1] == 2 * [ends[end] for ends in WIDE.values()]


@pytest.mark.usefixtures("loop")
def test_conversions(c_fmu: Fmus) -> None:
    parts = (
        part(c_fmu, "a", "kinds+state+through", u_int=3, u_bool=True, u_enum="fast"),
        part(c_fmu, "b", "3:kinds+state"),
    )
    links = (
        "a.y_int -> b.u_enum",
        "a.y_int * 0.5 + 1 -> b.u_real",
        "a.y_bool -> b.u_int",
        "a.y_enum -> b.u_int8",
        "a.y_bool * 2 - 5 -> b.u_floats[2]",
    )
    names = ("b.u_enum", "b.u_real", "b.u_int", "b.u_int8", "b.u_floats[1]", "b.u_floats[2]")
    found = watched(System("s", parts, links, Simulation(H, H)), names)
    assert found == [[3, 2.5, 1, 3, 0.0, -3.0]] * 2


@pytest.mark.usefixtures("loop")
@pytest.mark.parametrize(
    ("link", "value", "message"),
    [
        ("a.y_int -> b.u_uint8", 300, r"a\.y_int .* is 300, which b\.u_uint8 .* UInt8.* 0 to 255"),
        ("a.y_int -> b.u_uint64", -1, r"a\.y_int .* is -1, which b\.u_uint64 .* UInt64"),
        ("a.y_int -> b.u_enum", 4, r"a\.y_int .* is 4, which b\.u_enum .*off, slow, fast.* 1 to 3"),
    ],
)
def test_values_that_the_type_does_not_hold_end_the_run(
    c_fmu: Fmus, link: str, value: int, message: str
) -> None:
    parts = (
        part(c_fmu, "a", "kinds+state+through", u_int=1),
        part(c_fmu, "b", "3:kinds+state"),
    )
    with start(System("s", parts, (link,), Simulation(1.0, H))) as stepped:
        stepped.step()
        stepped["a.u_int"] = value
        with pytest.raises(RunError, match=message.replace(".*", "at t = 0.1 s", 1)):
            stepped.step()


def test_other_items_do_not_fit(c_fmu: Fmus, tmp_path: Path) -> None:
    from unit.cosim.exchange.test_versions import reworded

    other = reworded(c_fmu("kinds+state"), tmp_path / "x.fmu", 'name="slow"', 'name="idle"')
    parts = (part(c_fmu, "a", "kinds+state"), Component("b", FmuFile(other)))
    system = System("s", parts, ("a.y_enum -> b.u_enum",), Simulation(1.0, H))
    with pytest.raises(InputError, match=r"slow 2.* is expected.*same items|idle 2"):
        prepare(system)


@pytest.mark.usefixtures("loop")
def test_delayed_connections(c_fmu: Fmus) -> None:
    parts = (
        part(c_fmu, "a", "kinds+state", period=0.3),
        part(c_fmu, "b", "3:kinds+state+through"),
    )
    links = tuple(f"{link}, delayed" for link in linked(("a", "b")))
    names = [f"b.y_{kind}" for kind in KINDS]
    found = watched(System("s", parts, (*links, "b.y_real -> a.u_real"), Simulation(1.0, H)), names)
    late = [put(0, False, 1, "", periods(max(k - 1, 0) * H, 0.3)) for k in range(11)]
    assert [tuple(row) for row in found] == late


def test_loops_over_values_that_are_not_real_are_broken(c_fmu: Fmus) -> None:
    parts = tuple(
        part(c_fmu, n, "3:kinds+state+through", period=p) for n, p in (("a", 0.2), ("b", 0))
    )
    prepared = prepare(System("s", parts, linked(("a", "b", "a"), ("int",)), Simulation(0.4, H)))
    note = next(note for note in prepared.notes if "not Real" in note)
    assert "a.y_int -> b.u_int has the value of the previous step" in note
    assert [str(k) for k in prepared.wiring.links if k.delayed] == ["a.y_int -> b.u_int"]
    found = watched(prepared.system, ("a.y_int", "b.y_int"))
    # b gives what a gave before; a what b gives now, and the periods that have passed
    expected = [[0, 0]]
    for k in range(1, 5):
        b = expected[-1][0]
        expected.append([b + periods(k * H, 0.2), b])
    assert found == expected


def test_parameters_and_whole_arrays_are_connected(c_fmu: Fmus) -> None:
    values = {"u_list[2]": 5, "u_flags[1]": True, "offset": 4}
    parts = (
        part(c_fmu, "a", "3:kinds+state+through", **values),
        part(c_fmu, "b", "3:kinds+state"),
    )
    links = ("a.y_list -> b.u_list", "a.y_flags -> b.u_flags", "a.twice -> b.offset")
    names = [f"b.u_list[{k}]" for k in (1, 2, 3)] + ["b.u_flags[1]", "b.u_flags[2]", "b.offset"]
    system = System("s", parts, links, Simulation(H, H))
    assert watched(system, names)[0] == [0, 5, 0, True, False, 8]


@pytest.mark.usefixtures("loop")
def test_discrete_inputs_are_set_in_event_mode(c_fmu: Fmus) -> None:
    # the FMU refuses them in step mode, and refuses to enter event mode twice
    parts = (
        part(c_fmu, "a", "kinds+state", period=0.2),
        part(c_fmu, "b", "3:kinds+state+events"),
    )
    system = System("s", parts, linked(("a", "b")), Simulation(1.0, H))
    found = watched(system, [f"b.u_{kind}" for kind in KINDS])
    assert [tuple(row) for row in found] == [
        put(0, False, 1, "", periods(k * H, 0.2)) for k in range(11)
    ]


def test_a_change_leaves_nothing_of_the_past(c_fmu: Fmus) -> None:
    parts = (
        part(c_fmu, "a", "kinds+state", period=0.3),
        part(c_fmu, "b", "kinds+state"),
    )
    links = ("a.y_bool -> b.u_bool", "b.y_real -> a.u_real")
    kept: list[float] = []
    outcome = run(
        System("s", parts, links, Simulation(0.9, H)),
        observers=[lambda _, network: kept.append(network.last)],
    )
    jumps = [round(k * H, 9) for k, last in enumerate(kept) if k and not last]
    assert jumps == [0.3, 0.6, 0.9]
    note = next(note for note in outcome.notes if "not Real" in note)
    assert "3 steps" in note
    assert "a.y_bool at t = 0.3 s" in note
    assert "0.1 s late" in note


def test_steps_shrink_onto_a_change(c_fmu: Fmus) -> None:
    # b counts the time after the change: what is missed of it is how late the change acts
    parts = (
        part(c_fmu, "a", "kinds+state", period=0.7310),
        part(c_fmu, "b", "kinds+state"),
    )
    simulation = Simulation(1.0, H, coupling_tolerance=1e-4)
    system = System("s", parts, ("a.y_bool -> b.u_bool", "b.y_real -> a.u_real"), simulation)
    found = watched(system, ["b.y_real"])[-1][0]
    assert found == pytest.approx(1 - 0.731, abs=2e-6)  # a times its period to 1e-6


def test_python_reads_and_sets_all_types(c_fmu: Fmus) -> None:
    parts = (part(c_fmu, "a", "kinds+state"), part(c_fmu, "b", "3:kinds+state"))
    with start(System("s", parts, linked(("a", "b")), Simulation(1.0, H))) as stepped:
        given = {"a.u_int": -7, "a.u_bool": True, "a.u_enum": "fast", "a.u_text": "grüß",
                 "b.u_uint64": 2**64 - 1, "b.u_list[2]": 5, "b.u_words[2]": "w"}  # fmt: skip
        for name, value in given.items():
            stepped[name] = value
        assert [stepped[name] for name in given] == [-7, True, 3, "grüß", 2**64 - 1, 5, "w"]
        point = stepped.step()
        assert [point[f"b.u_{kind}"] for kind in KINDS] == [-7, True, 3, "grüß"]
        assert point["b.y_uint64"] == 2**64 - 1


def test_buses_carry_them(c_fmu: Fmus) -> None:
    parts = (part(c_fmu, "a", "kinds+state", period=0.3), part(c_fmu, "b", "3:kinds+state"))
    buses = {"bus": {"on": "Boolean", "mode": "Enumeration", "text": "String"}}
    links = (
        "a.y_bool -> bus.on", "bus.on -> b.u_bool", "bus.on -> b.u_int",
        "a.y_enum -> bus.mode", "bus.mode -> b.u_enum",
    )  # fmt: skip
    system = System("s", parts, links, Simulation(0.5, H), buses=buses)
    assert watched(system, ["b.u_bool", "b.u_int", "b.u_enum"])[-1] == [True, 1, 2]


def test_a_system_without_reals_says_why_its_error_is_not_known(c_fmu: Fmus) -> None:
    parts = (part(c_fmu, "a", "kinds+state"), part(c_fmu, "b", "kinds+state"))
    both = (*linked(("a", "b", "a"), ("bool",)),)
    outcome = run(System("s", parts, both, Simulation(1.0, H)))
    assert outcome.certificate == "no Real is exchanged"


def test_the_same_bits_with_and_without_other_values(c_fmu: Fmus) -> None:
    # a Boolean that never changes does not disturb the Reals
    parts = (
        Component("a", FmuFile(c_fmu("mass+state")), {"stiffness": 1.0, "body.m.x": 1.0}),
        Component("b", FmuFile(c_fmu("partner+state"))),
        part(c_fmu, "c", "kinds+state"),
        part(c_fmu, "d", "3:kinds+state"),
    )
    names = ["a.body.m.x", "b.x"]
    simulation = Simulation(3.0, H)
    plain = watched(System("s", parts, ("a.m <-> b.end",), simulation), names)
    more = ("a.m <-> b.end", *linked(("c", "d")))
    assert np.array_equal(watched(System("s", parts, more, simulation), names), plain)
