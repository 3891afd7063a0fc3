"""Values that are not Real on connections: each type and version of FMI, in C and in Python."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import pytest
from support.small_systems import Fmus, observed, system, watched

from m4e_fmi.cosim import Simulation, System, prepare, run, start
from m4e_fmi.errors import RunError

KINDS = ("int", "bool", "enum", "text")
H = 0.1


def pair(
    fmus: Fmus, a: str, b: str, *links: str, stop: float = 1.0, start: Any = None, **more: Any
) -> System:
    """Two FMUs of kinds.c; the first counts periods of 0.3 s."""
    start = start or {"a": {"period": 0.3}}
    settings = Simulation(stop, H, **more)
    return system(fmus, {"a": a, "b": b}, *links, start=start, simulation=settings)


def linked(names: Sequence[str], kinds: Sequence[str] = KINDS) -> tuple[str, ...]:
    """Connections of all types from each component to the next."""
    return tuple(f"{a}.y_{k} -> {b}.u_{k}" for a, b in pairwise(names) for k in kinds)


def put(time: float) -> list[Any]:
    """Outputs of kinds.c with a period of 0.3 s and without inputs."""
    n = int(max(time, 0.0) / 0.3 + 1e-6)
    return [n, bool(n & 1), n % 3 + 1, str(n) if n else ""]


@pytest.mark.usefixtures("loop")
def test_values_pass_through_along_declared_dependencies(c_fmu: Fmus) -> None:
    """To b within the instant, to c a step later."""
    names = {"c": "3:kinds+state", "b": "3:kinds+state+through", "a": "kinds+state"}
    chain = system(c_fmu, names, *linked(("a", "b", "c")), start={"a": {"period": 0.3}})
    for time, *row in observed(chain, *(f"{n}.y_{kind}" for n in "abc" for kind in KINDS))[0]:
        assert row == [*put(time), *put(time), *put(time - H)]


@pytest.mark.usefixtures("loop")
def test_delayed_connections(c_fmu: Fmus) -> None:
    links = (*(f"{link}, delayed" for link in linked(("a", "b"))), "b.y_real -> a.u_real")
    given = pair(c_fmu, "kinds+state", "3:kinds+state+through", *links)
    for time, *row in observed(given, *(f"b.y_{kind}" for kind in KINDS))[0]:
        assert row == put(time - H)


@pytest.mark.usefixtures("loop")
def test_discrete_inputs_are_set_in_event_mode(c_fmu: Fmus) -> None:
    """The FMU refuses them in step mode, and refuses to enter event mode twice."""
    given = pair(c_fmu, "kinds+state", "3:kinds+state+events", *linked(("a", "b")))
    for time, *row in observed(given, *(f"b.u_{kind}" for kind in KINDS))[0]:
        assert row == put(time)


@pytest.mark.usefixtures("loop")
@pytest.mark.parametrize("least", [True, False])
def test_integers_of_all_widths(c_fmu: Fmus, least: bool) -> None:
    ends: dict[str, Any] = {}
    for bits in (8, 16, 32, 64):
        ends[f"int{bits}"] = -(2 ** (bits - 1)) if least else 2 ** (bits - 1) - 1
        ends[f"uint{bits}"] = 0 if least else 2**bits - 1
    links = tuple(f"a.y_{kind} -> b.u_{kind}" for kind in ends)
    start = {"a": {f"u_{kind}": end for kind, end in ends.items()}}
    given = pair(c_fmu, "3:kinds+state+through", "3:kinds+state", *links, stop=0.2, start=start)
    found = watched(given, *(f"b.{way}_{kind}" for way in "uy" for kind in ends))
    assert found[-1] == 2 * [*ends.values()]


@pytest.mark.usefixtures("loop")
def test_conversions(c_fmu: Fmus) -> None:
    links = {
        "a.y_int -> b.u_enum": 3,
        "a.y_int * 0.5 + 1 -> b.u_real": 2.5,
        "a.y_bool -> b.u_int": 1,
        "a.y_enum -> b.u_int8": 3,
        "a.y_bool * 2 - 5 -> b.u_floats[2]": -3.0,
    }
    start = {"a": {"u_int": 3, "u_bool": True, "u_enum": "fast"}}
    given = pair(c_fmu, "kinds+state+through", "3:kinds+state", *links, stop=H, start=start)
    found = watched(given, *(link.partition(" -> ")[2] for link in links))
    assert found == [[*links.values()]] * 2


@pytest.mark.usefixtures("loop")
@pytest.mark.parametrize(
    ("link", "value", "message"),
    [
        ("a.y_int -> b.u_uint8", 300, r"is 300, which b\.u_uint8 .* UInt8.* 0 to 255"),
        ("a.y_int -> b.u_uint64", -1, r"is -1, which b\.u_uint64 .* UInt64"),
        ("a.y_int -> b.u_enum", 4, r"is 4, which b\.u_enum .*off, slow, fast.* 1 to 3"),
    ],
)
def test_values_that_the_type_does_not_hold_end_the_run(
    c_fmu: Fmus, link: str, value: int, message: str
) -> None:
    given = pair(c_fmu, "kinds+state+through", "3:kinds+state", link, start={"a": {"u_int": 1}})
    with start(given) as stepped:
        stepped.step()
        stepped["a.u_int"] = value
        with pytest.raises(RunError, match=rf"a\.y_int at t = 0\.1 s {message}"):
            stepped.step()


def test_loops_over_values_that_are_not_real_are_broken(c_fmu: Fmus) -> None:
    fmu = "3:kinds+state+through"
    prepared = prepare(pair(c_fmu, fmu, fmu, *linked(("a", "b", "a"), ("int",))))
    note = next(note for note in prepared.notes if "not Real" in note)
    assert "a.y_int -> b.u_int has the value of the previous step" in note
    assert [str(k) for k in prepared.wiring.links if k.delayed] == ["a.y_int -> b.u_int"]
    last = 0
    for time, a, b in observed(prepared.system, "a.y_int", "b.y_int")[0]:
        # b gives what a gave before; a what b gives now, and the periods that have passed
        assert (a, b) == (last + put(time)[0], last)
        last = a


def test_parameters_and_whole_arrays_are_connected(c_fmu: Fmus) -> None:
    links = ("a.y_list -> b.u_list", "a.y_flags -> b.u_flags", "a.twice -> b.offset")
    start = {"a": {"u_list[2]": 5, "u_flags[1]": True, "offset": 4}}
    given = pair(c_fmu, "3:kinds+state+through", "3:kinds+state", *links, stop=H, start=start)
    names = [f"b.u_list[{k}]" for k in (1, 2, 3)] + ["b.u_flags[1]", "b.u_flags[2]", "b.offset"]
    assert watched(given, *names)[0] == [0, 5, 0, True, False, 8]


def test_a_change_leaves_nothing_of_the_past(c_fmu: Fmus) -> None:
    links = ("a.y_bool -> b.u_bool", "b.y_real -> a.u_real")
    kept: list[float] = []
    outcome = run(
        pair(c_fmu, "kinds+state", "kinds+state", *links, stop=0.9),
        observers=[lambda _, network: kept.append(network.last)],
    )
    jumps = [round(k * H, 9) for k, last in enumerate(kept) if k and not last]
    assert jumps == [0.3, 0.6, 0.9]
    note = next(note for note in outcome.notes if "not Real" in note)
    assert all(text in note for text in ("3 steps", "a.y_bool at t = 0.3 s", "0.1 s late"))


def test_steps_shrink_onto_a_change(c_fmu: Fmus) -> None:
    """b counts the time after the change: what is missed of it is how late the change acts."""
    links, start = ("a.y_bool -> b.u_bool", "b.y_real -> a.u_real"), {"a": {"period": 0.7310}}
    given = pair(c_fmu, "kinds+state", "kinds+state", *links, start=start, coupling_tolerance=1e-4)
    # a times its period to 1e-6
    assert watched(given, "b.y_real")[-1][0] == pytest.approx(1 - 0.731, abs=2e-6)


def test_python_reads_and_sets_all_types(c_fmu: Fmus) -> None:
    with start(pair(c_fmu, "kinds+state", "3:kinds+state", *linked(("a", "b")))) as stepped:
        given = {"a.u_int": -7, "a.u_bool": True, "a.u_enum": "fast", "a.u_text": "grüß",
                 "b.u_uint64": 2**64 - 1, "b.u_list[2]": 5, "b.u_words[2]": "w"}  # fmt: skip
        for name, value in given.items():
            stepped[name] = value
        assert [stepped[name] for name in given] == [-7, True, 3, "grüß", 2**64 - 1, 5, "w"]
        point = stepped.step()
        assert [point[f"b.u_{kind}"] for kind in KINDS] == [-7, True, 3, "grüß"]
        assert point["b.y_uint64"] == 2**64 - 1
