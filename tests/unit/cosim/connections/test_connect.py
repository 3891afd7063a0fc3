"""Connection texts: what they connect, and one clear message with place for every mistake."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from support.described import described

from m4e_fmi.cosim import Component, FmuFile, Port, Simulation, System, load_system, prepare
from m4e_fmi.cosim.connections.connect import connect
from m4e_fmi.cosim.connections.links import Wiring
from m4e_fmi.cosim.connections.missing.unconnected_parameters import unconnected_parameters
from m4e_fmi.errors import InputError
from m4e_fmi.fmu.importer.reading import Description

Fmus = Callable[[str], Path]

SIMULATION = Simulation(stop_time=1, step_size=0.1)


def wired(descriptions: dict[str, Description], *connections: str) -> Wiring:
    components = tuple(Component(name, FmuFile(Path(f"{name}.fmu"))) for name in descriptions)
    return connect(System("s", components, connections, SIMULATION), descriptions)


BUOY = described(
    "buoy",
    ("body.float.x", "output", "m"),
    ("body.float.vx", "output", "m/s"),
    ("body.float.ax", "output", "m/s2"),
    ("body.float.force_x", "input", "N"),
    ("point.float.x", "output", "m"),
    ("point.fairlead.x", "output", "m"),
    ("point.fairlead.force_x", "input", "N"),
    ("added_mass[1,1]", "parameter", "kg"),
    ("added_mass[1,2]", "parameter", "kg"),
    ("mass", "parameter", "kg"),
)
HYDRO = described(
    "hydro",
    ("float.x", "input", "m"),
    ("float.vx", "input", "m/s"),
    ("float.force_x", "output", "N"),
    ("added_mass[1,1]", "calculatedParameter", "kg"),
    ("added_mass[1,2]", "calculatedParameter", "kg"),
    ("displacement", "calculatedParameter", "kg"),
    ("power", "output", "W"),
    ("short", "output", "mm"),
    ("plain", "output", ""),
    ("small[1,1]", "calculatedParameter", "kg"),
    ("hot", "calculatedParameter", "degC"),
    ("warm", "parameter", "K"),
    ("moment", "parameter", "N.m"),
    ("energy", "output", "kJ"),
)
BOTH = {"buoy": BUOY, "hydro": HYDRO}


def test_a_connector_connects_equal_names_both_ways() -> None:
    wiring = wired(BOTH, "buoy.body.float <-> hydro.float")
    assert {str(link) for link in wiring.links} == {
        "buoy.body.float.x -> hydro.float.x",
        "buoy.body.float.vx -> hydro.float.vx",
        "hydro.float.force_x -> buoy.body.float.force_x",
    }
    assert wiring.unconnected == (Port("buoy", "point.fairlead.force_x"),)
    assert [bond.name for bond in wiring.bonds] == ["buoy.body.float <-> hydro.float"]
    axis = wiring.bonds[0].axes[0]
    assert str(axis.force.source) == "hydro.float.force_x"
    assert str(axis.velocity.source) == "buoy.body.float.vx"
    assert axis.position is not None


def test_a_connector_is_found_by_its_last_part_if_that_is_unique() -> None:
    other = {"buoy": BUOY, "line": described("line", ("end.force_x", "output", "N"))}
    wiring = wired(other, "line.end <-> buoy.fairlead")
    assert [str(link.target) for link in wiring.links] == ["buoy.point.fairlead.force_x"]


def test_an_array_is_carried_into_parameters_once() -> None:
    wiring = wired(BOTH, "hydro.added_mass -> buoy.added_mass")
    assert wiring.links == ()
    assert {str(link.target) for link in wiring.initial_links} == {
        "buoy.added_mass[1,1]",
        "buoy.added_mass[1,2]",
    }


@pytest.mark.parametrize(
    ("connections", "missing"),
    [((), True), (("hydro.added_mass -> buoy.added_mass",), False)],
)
def test_what_is_calculated_and_not_carried_over_is_told(
    connections: tuple[str, ...], *, missing: bool
) -> None:
    parts = tuple(Component(name, FmuFile(Path(name))) for name in BOTH)
    system = System("s", parts, connections, SIMULATION)
    found = unconnected_parameters(system, BOTH, connect(system, BOTH))
    text = (
        "hydro.added_mass is calculated, but not transferred: 'hydro.added_mass -> buoy.added_mass'"
    )
    assert found == ([text] if missing else [])


@pytest.mark.parametrize("variability", ["tunable", "fixed"])
def test_a_matrix_that_varies_and_is_not_carried_is_told(
    variability: str,
) -> None:
    names = ("added_mass[1,1]", "added_mass[1,2]", "plain")
    hydro = described("hydro", *((name, "output", "kg") for name in names))
    buoy = described("buoy", *((name, "parameter", "kg") for name in names))
    table = {n: replace(v, variability=variability) for n, v in buoy.variables.items()}
    both = {"buoy": replace(buoy, variables=table), "hydro": hydro}
    parts = tuple(Component(name, FmuFile(Path(name))) for name in both)

    def found(*connections: str) -> list[str]:
        system = System("s", parts, connections, SIMULATION)
        return unconnected_parameters(system, both, connect(system, both))

    advice = {
        "tunable": "'hydro.added_mass -> buoy.added_mass'",
        "fixed": "buoy.added_mass, which is fixed, keeps its start value while hydro.added_mass "
        "varies",
    }[variability]
    assert found() == [f"hydro.added_mass is calculated, but not transferred: {advice}"]
    if variability == "tunable":
        assert found("hydro.added_mass -> buoy.added_mass") == []


def test_no_connection_is_suggested_between_arrays_of_two_sizes() -> None:
    large = described(
        "hydro", *((f"added_mass[1,{k}]", "calculatedParameter", "kg") for k in "123")
    )
    both = {"buoy": BOTH["buoy"], "hydro": large}
    parts = tuple(Component(name, FmuFile(Path(name))) for name in both)
    system = System("s", parts, (), SIMULATION)
    assert unconnected_parameters(system, both, connect(system, both)) == [
        "hydro.added_mass is calculated, but not transferred: buoy.added_mass, which differs in "
        "size (3 and 2 elements), keeps its start value"
    ]


def test_a_variable_without_unit_fits_any() -> None:
    assert wired(BOTH, "hydro.plain -> buoy.body.float.force_x").links


@pytest.mark.parametrize(
    ("connection", "factor", "offset"),
    [
        ("hydro.short -> hydro.float.x", 1e-3, 0.0),
        ("hydro.short * 2.5 + 1 -> hydro.float.x", 2.5e-3, 1.0),
        ("hydro.short * -2.5e1 - .5 -> hydro.float.x", -2.5e-2, -0.5),
        ("hydro.short * 2 -> hydro.float.x, units ignored", 2.0, 0.0),
        ("hydro.power -> buoy.body.float.force_x, units ignored", 1.0, 0.0),
        ("hydro.hot -> hydro.warm", 1.0, 273.15),
        ("hydro.hot * 2 + 1 -> hydro.warm", 2.0, 547.3),
    ],
)
def test_units_are_converted_before_factor_and_offset(
    connection: str, factor: float, offset: float
) -> None:
    wiring = wired(BOTH, connection)
    (link,) = (*wiring.links, *wiring.initial_links)
    assert (link.factor, link.offset) == pytest.approx((factor, offset), rel=1e-15)


@pytest.mark.parametrize(
    ("connection", "message", "remedy"),
    [
        ("buoy.float", "not a connection", "a.group <-> b.group"),
        ("bouy.float <-> hydro.float", "unknown component 'bouy'", "did you mean 'buoy'?"),
        ("buoy <-> hydro.float", "'buoy' names no variable", "buoy.name"),
        ("buoy.float <-> hydro.float", "several connectors", "body.float, point.float"),
        ("buoy.fairled <-> hydro.float", "no connector 'fairled'", "did you mean 'fairlead'?"),
        ("buoy.float.x -> hydro.float.x", "no variable 'float.x'", "body.float.x"),
        ("buoy.point.fairlead <-> buoy.point.float", "no output and input", "x (output)"),
        ("buoy.mass -> hydro.float.x", "buoy.mass (parameter) is not an output", "left"),
        ("hydro.power -> buoy.body.float.x", "x (output) is not an input", "input or a parameter"),
        ("hydro.displacement -> buoy.body.float.force_x", "is constant", "connect it to a par"),
        ("hydro.power -> buoy.body.float.force_x", "in W, buoy", "kg.m2/s3 is not kg.m/s2"),
        ("hydro.power -> buoy.body.float.force_x", "in W, buoy", "units ignored"),
        ("hydro.energy -> hydro.moment", "in kJ, hydro.moment", "an energy is not a moment"),
        ("hydro.float.force_x * 0 -> buoy.body.float.force_x", "factor 0", "no factor 0"),
        ("hydro.float.force_x * a -> buoy.body.float.force_x", "more than a variable", "a.y * 2.5"),
        ("hydro.float.force_x / 2 -> buoy.body.float.force_x", "more than a variable", "a.y * 2.5"),
        ("buoy.body.float * 2 <-> hydro.float", "takes no factor", "'->'"),
        ("hydro.float -> buoy.body.float", "are connectors", "'hydro.float <-> buoy.body.float'"),
        ("hydro.float -> buoy.body.float.force_x", "hydro.float is a connector", "one of its var"),
        ("hydro.float.force_x <-> buoy.body.float.force_x", "are variables", "with '->'"),
        ("hydro.float <-> buoy.body.float.x", "float.x is a variable", "with '->'"),
        ("hydro.hot -> buoy.mass", "in degC, buoy.mass expects kg", "K is not kg"),
        ("hydro.small -> buoy.added_mass", "differ in size", "2 elements [1,1] to [1,2]"),
    ],
)
def test_one_mistake_one_message_with_remedy(connection: str, message: str, remedy: str) -> None:
    with pytest.raises(InputError) as caught:
        wired(BOTH, connection)
    (problem,) = caught.value.problems
    assert message in problem.message
    assert remedy in problem.remedy


def test_an_output_is_carried_into_a_tunable_parameter_at_every_point() -> None:
    parts = {**BOTH, "buoy": with_variability(BUOY, "tunable")}
    wiring = wired(
        parts, "hydro.plain -> buoy.mass, delayed", "hydro.added_mass -> buoy.added_mass"
    )
    (link,) = wiring.links
    assert (str(link), link.delayed) == ("hydro.plain -> buoy.mass", True)
    assert len(wiring.initial_links) == 2


def test_an_output_does_not_lead_into_a_fixed_parameter() -> None:
    parts = {**BOTH, "buoy": with_variability(BUOY, "fixed")}
    with pytest.raises(InputError) as caught:
        wired(parts, "hydro.plain -> buoy.mass")
    (problem,) = caught.value.problems
    assert "fixed parameter, which cannot follow the output hydro.plain" in problem.message
    assert "tunable: true" in problem.remedy


def with_variability(description: Description, variability: str) -> Description:
    """The description with this variability of all parameters."""
    variables = {
        name: replace(v, variability=variability) if v.causality == "parameter" else v
        for name, v in description.variables.items()
    }
    return replace(description, variables=variables)


def test_forces_and_velocities_may_be_connected_one_by_one() -> None:
    """The power is the same; what the body takes of the force is known where a factor is given."""
    back = ("buoy.body.float.vx -> hydro.float.vx", "buoy.body.float.x -> hydro.float.x")
    wiring = wired(BOTH, *back, "hydro.float.force_x * -0.5 -> buoy.body.float.force_x")
    (bond,) = wiring.bonds
    (axis,) = bond.axes
    assert str(axis.velocity.source) == "buoy.body.float.vx"
    assert axis.position is not None
    assert axis.share == -0.5
    assert bond.name == "hydro.float.force_x * -0.5 -> buoy.body.float.force_x"
    assert not wired(BOTH, *back, "hydro.float.force_x + 3 -> buoy.body.float.force_x").bonds
    assert not wired(BOTH, "hydro.float.force_x -> buoy.body.float.force_x").bonds


def test_two_sources_for_one_input_are_refused() -> None:
    with pytest.raises(InputError) as caught:
        wired(
            BOTH,
            "buoy.body.float <-> hydro.float",
            "hydro.float.force_x -> buoy.fairlead.force_x".replace("fairlead", "point.fairlead"),
            "buoy.point.fairlead.x -> hydro.float.x",
        )
    (problem,) = caught.value.problems
    assert "hydro.float.x has two sources: buoy.body.float.x and buoy.point.fairlead.x" in str(
        problem
    )
    assert "'buoy.body.float <-> hydro.float'" in problem.remedy


def test_problems_with_real_fmus_stand_at_their_place_in_the_file(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    path = tmp_path / "system.yaml"
    path.write_text(
        f"""\
name: pair
components:
  body: {{fmu: {c_fmu("mass")}, start: {{body.m.y: 1, body.m.ax: 0}}}}
  spring: {{fmu: {c_fmu("mm_spring")}}}
connections:
  - body.m <-> spring.end
  - body.m.ax -> spring.end.vx
  - body.body.m.ax -> spring.end.x
simulation: {{stop_time: 1, step_size: 0.1}}
"""
    )
    with pytest.raises(InputError) as caught:
        prepare(load_system(path))
    told = str(caught.value)
    assert "system.yaml:8:5: body.body.m.ax is in m/s2, spring.end.x expects mm" in told
    assert "system.yaml:7:5" in told
    assert "'body' has no variable 'body.m.y'" in told
    assert "body.body.m.ax (output) takes no start value" in told


def test_a_rate_is_carried_over_like_what_it_moves(c_fmu: Fmus) -> None:
    parts = tuple(Component(n, FmuFile(c_fmu(m))) for n, m in (("a", "mass"), ("b", "line")))
    uneven = ("a.body.m.x * 2 -> b.end.x", "a.body.m.vx -> b.end.vx")
    with pytest.raises(InputError, match=r"end\.vx is declared as the rate of end\.x") as caught:
        prepare(System("s", parts, uneven, SIMULATION))
    assert "give both the factor 2" in str(caught.value)
    even = ("a.body.m.x * 2 + 1 -> b.end.x", "a.body.m.vx * 2 -> b.end.vx")
    assert len(prepare(System("s", parts, even, SIMULATION)).wiring.links) == 2


def test_the_systems_own_inputs_and_outputs_are_checked(c_fmu: Fmus) -> None:
    parts = tuple(Component(n, FmuFile(c_fmu(m))) for n, m in (("a", "mass"), ("b", "spring")))
    inputs = {"one": ("a.body.m.force_x",), "two": ("a.body.m.x", "c.u"), "three": ("b.end.y",)}
    outputs = {"four": "b.end.force_x", "five": "b.end.x"}
    system = System("s", parts, ("a.body.m <-> b.end",), SIMULATION, inputs=inputs, outputs=outputs)
    with pytest.raises(InputError) as caught:
        prepare(system)
    messages = [problem.message for problem in caught.value.problems]
    for told in (
        "'one' stands for a.body.m.force_x, which is connected",
        "'two' stands for a.body.m.x (output), which is no input",
        "'two' stands for 'c.u', which is no variable",
        "'three' stands for 'b.end.y', which is no variable",
        "'five' stands for b.end.x (input), which is no output",
    ):
        assert any(told in message for message in messages)
    assert len(messages) == 5


def test_a_connector_carries_what_is_calculated_into_a_parameter() -> None:
    """Once, beside its inputs and outputs; a connection by '->' is asked before it."""
    buoy = described(
        "buoy",
        ("body.float.x", "output", "m"),
        ("body.float.mass", "parameter", "kg"),
        ("mass", "parameter", "kg"),
    )
    hydro = described(
        "hydro",
        ("float.x", "input", "m"),
        ("float.mass", "calculatedParameter", "t"),
        ("float.drag", "parameter", "kg"),
        ("mass", "calculatedParameter", "kg"),
        ("other", "calculatedParameter", "kg"),
    )
    both = {"buoy": buoy, "hydro": hydro}
    for connection in ("buoy.float <-> hydro.float", "hydro.float <-> buoy.float"):
        wiring = wired(both, connection)
        assert [str(link) for link in wiring.links] == ["buoy.body.float.x -> hydro.float.x"]
        (link,) = wiring.initial_links
        assert str(link) == "hydro.float.mass -> buoy.body.float.mass"
        assert link.factor == 1000.0
    wiring = wired(both, "buoy.float <-> hydro.float", "hydro.other + 5 -> buoy.body.float.mass")
    (link,) = wiring.initial_links
    assert (str(link.source), link.offset) == ("hydro.other", 5.0)


def test_parameters_of_other_types_are_no_masses() -> None:
    text = replace(BUOY.variables["mass"], name="note", type="String", start="calm")
    noted = replace(BUOY, variables={**BUOY.variables, "note": text})
    assert wired({**BOTH, "buoy": noted}, "buoy.body.float <-> hydro.float").links
