"""Reading SSP packages: what is flattened, what is refused, what is told."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from support.packages import (
    component,
    connection,
    description,
    package,
    parameter_mapping,
    parameter_set,
)

from m4e_fmi.cosim import System, load_system, prepare, run
from m4e_fmi.errors import InputError
from m4e_fmi.units import Quantity

Fmus = Callable[[str], Path]
Files = dict[str, str | Path]

STAGE = ("input u Real", "output y Real")
HALF = '<ssc:LinearTransformation factor="0.5" offset="1"/>'


@pytest.fixture
def stages(c_fmu: Fmus) -> Files:
    """y = gain·u + t, in seconds."""
    return {"resources/s.fmu": c_fmu("stage")}


def elements(*items: str) -> str:
    return f"<ssd:Elements>{''.join(items)}</ssd:Elements>"


def connections(*items: str) -> str:
    return f"<ssd:Connections>{''.join(items)}</ssd:Connections>"


def inner(name: str, content: str, *connectors: str) -> str:
    rows = component("x", "y", *connectors)
    rows = rows[rows.index("<ssd:Connectors>") : rows.index("</ssd:Component>")]
    return f'<ssd:System name="{name}">{rows}{content}</ssd:System>'


def read(path: Path, ssd: str, files: Files) -> System:
    return load_system(package(path / "s.ssp", ssd, files))


def problems(path: Path, ssd: str, files: Files) -> list[str]:
    with pytest.raises(InputError) as caught:
        read(path, ssd, files)
    return [str(problem) for problem in caught.value.problems]


def test_systems_in_systems_are_flattened(tmp_path: Path, stages: Files) -> None:
    inside = inner(
        "row",
        elements(component("a", "s.fmu", *STAGE), component("b", "s.fmu", *STAGE))
        + connections(
            connection("in", "a/u"), connection("a/y", "b/u", HALF), connection("b/y", "out", HALF)
        ),
        "input in Real",
        "output out Real",
    )
    ssd = description(
        elements(component("first", "s.fmu", *STAGE), inside, component("last", "s.fmu", *STAGE))
        + connections(connection("first/y", "row/in", HALF), connection("row/out", "last/u", HALF))
    )
    system = read(tmp_path, ssd, stages)
    assert [part.name for part in system.components] == ["first", "row_a", "row_b", "last"]
    # (y/2 + 1)/2 + 1
    assert set(system.connections) == {
        "first.y * 0.5 + 1.0 -> row_a.u",
        "row_a.y * 0.5 + 1.0 -> row_b.u",
        "row_b.y * 0.25 + 1.5 -> last.u",
    }
    assert "component 'row.a' is called 'row_a' here" in system.notes
    seen: list[float] = []
    run(
        system.changed(start={"first.u": 8.0}, stop_time=0.1, step_size=0.1),
        observers=[lambda _, network: seen.append(network.read("last.y"))],
        build_directory=tmp_path,
    )
    assert seen[0] == pytest.approx(((8 / 2 + 1) / 2 + 1) * 0.25 + 1.5, abs=1e-15)


def test_an_offset_inside_is_in_the_unit_of_its_connector(tmp_path: Path, stages: Files) -> None:
    units = '<ssd:Units><ssc:Unit name="ms"><ssc:BaseUnit s="1" factor="0.001"/></ssc:Unit>'
    inside = inner(
        "in",
        elements(component("b", "s.fmu", *STAGE)) + connections(connection("u", "b/u", HALF)),
        "input u Real ms",
    )
    ssd = description(
        elements(component("a", "s.fmu", *STAGE), inside)
        + connections(connection("a/y", "in/u", HALF)),
        units=f"{units}</ssd:Units>",
    )
    # (y in ms)/2 + 1 ms; that in s, halved, and 1 s
    system = read(tmp_path, ssd, stages)
    assert system.connections == ("a.y * 0.25 + 1.0005 -> in_b.u",)
    told = problems(tmp_path, ssd.replace('"u" kind="input"><ssc:Real unit="ms"', '"u" '
                    'kind="input"><ssc:Real unit="m"'), {**stages})  # fmt: skip
    assert any("'m' is not a unit" in t or "where the unit is not known" in t for t in told)


def test_signal_dictionaries_are_refused(tmp_path: Path, stages: Files) -> None:
    bus = (
        '<ssd:SignalDictionaryReference name="w" dictionary="bus"><ssd:Connectors>'
        '<ssd:Connector name="speed" kind="inout"/></ssd:Connectors>'
        "</ssd:SignalDictionaryReference>"
    )
    content = elements(bus, component("a", "s.fmu", *STAGE))
    connected = description(content + connections(connection("a/y", "w/speed")))
    told = problems(tmp_path, connected, stages)
    assert "'w' refers to a signal dictionary, which is not read" in told[0]


def test_what_others_leave_empty_is_not_given(tmp_path: Path, stages: Files) -> None:
    """OMSimulator writes units of no name, and the system itself as an element of no name."""
    pair = elements(component("a", "s.fmu", *STAGE), component("b", "s.fmu", *STAGE))
    own = '<ssd:Connector name="in" kind="input"><ssc:Real unit=""/></ssd:Connector>'
    own = f"<ssd:Connectors>{own}</ssd:Connectors>"
    empty = connection("in", "a/u", attributes='startElement=""')
    joined = connections(empty, connection("b/u", "a/y"))  # the other way is allowed, too
    system = read(tmp_path, description(own + pair + joined), stages)
    assert system.connections == ("a.y -> b.u",)


def test_the_system_has_inputs_and_outputs_of_its_own(tmp_path: Path, stages: Files) -> None:
    own = inner("x", "", "input wish Real", "output result Real", "input loose Real")
    own = own[own.index("<ssd:Connectors>") : own.index("</ssd:System>")]
    given = parameter_set({"wish": 'Real value="3"'})
    binding = (
        "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>"
        f"{given}</ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"
    )
    content = (
        own
        + binding
        + elements(component("a", "s.fmu", *STAGE))
        + connections(connection("wish", "a/u"), connection("a/y", "result"))
    )
    system = read(tmp_path, description(content), stages)
    assert dict(system.inputs) == {"wish": ("a.u",)}
    assert dict(system.outputs) == {"result": "a.y"}
    assert dict(system.components[0].start) == {"u": 3.0}
    assert "the system's own input 'loose' is connected to nothing" in system.notes


def binding(attributes: str, inside: str = "") -> str:
    return f"<ssd:ParameterBinding {attributes}>{inside}</ssd:ParameterBinding>"


def test_bindings_further_out_and_later_ones_win(tmp_path: Path, stages: Files) -> None:
    def bound(*items: str) -> str:
        return f"<ssd:ParameterBindings>{''.join(items)}</ssd:ParameterBindings>"

    files: Files = {
        **stages,
        "resources/one.ssv": parameter_set({"gain": 'Real value="1"', "u": 'Real value="1"'}),
        "resources/two.ssv": parameter_set({"gain": 'Real value="2"', "other": 'Real value="2"'}),
        "resources/three.ssv": parameter_set({"row.b.gain": 'Real value="3"'}),
    }
    one, two = binding('source="resources/one.ssv"'), binding('source="resources/two.ssv"')
    ssd = description(
        bound(binding('source="resources/three.ssv"'))
        + elements(
            component("a", "s.fmu", *STAGE, bindings=bound(one, two)),
            inner(
                "row",
                bound(binding('source="resources/one.ssv" prefix="c."'))
                + elements(
                    component("b", "s.fmu", *STAGE, bindings=bound(two, one)),
                    component("c", "s.fmu", *STAGE),
                ),
                "output none Real",
            ).replace("<ssd:Connectors>", "<!-- --><ssd:Connectors>"),
        )
    )
    system = read(tmp_path, ssd, files)
    starts = {part.name: dict(part.start) for part in system.components}
    assert starts == {
        "a": {"gain": 2.0, "u": 1.0},
        "row_b": {"gain": 3.0, "u": 1.0},
        "row_c": {"gain": 1.0, "u": 1.0},
    }
    assert "parameter 'other' of a reaches no variable: it is left out" in system.notes


def test_mapped_and_converted_parameters(tmp_path: Path, c_fmu: Fmus) -> None:
    units = """<ssd:Units><ssc:Unit name="ft"><ssc:BaseUnit m="1" factor="0.3048"/></ssc:Unit>
               </ssd:Units>"""
    given = {"length": 'Real value="10" unit="ft"', "state": 'Boolean value="true"'}
    double = '<ssc:LinearTransformation factor="2" offset="1"/>'
    mapping = parameter_mapping({"body.m.x": ("length", double), "body.m.vx": "speed"})
    bare = parameter_mapping({"body.m.x": ("length", double)}).replace(
        'target="body.m.x"', 'target="body.m.x" suppressUnitConversion="true"'
    )
    files: Files = {
        "resources/m.fmu": c_fmu("mass"),
        "resources/set.ssv": parameter_set({**given, "speed": 'Real value="2"'}, units),
        "resources/set.ssm": mapping,
        "resources/bare.ssm": bare,
        "resources/plain.ssm": parameter_mapping({"body.m.x": "length"}),
    }

    def start(mapped: str) -> dict:
        inside = f'<ssd:ParameterMapping source="resources/{mapped}"/>'
        bindings = (
            "<ssd:ParameterBindings>"
            + binding('source="resources/set.ssv"', inside)
            + "</ssd:ParameterBindings>"
        )
        ssd = description(elements(component("m", "m.fmu", bindings=bindings)))
        return dict(read(tmp_path, ssd, files).components[0].start)

    assert start("set.ssm") == pytest.approx({"body.m.x": 2 * 3.048 + 1, "body.m.vx": 2.0})
    assert start("bare.ssm") == {"body.m.x": 21.0}
    quantity = start("plain.ssm")["body.m.x"]
    assert isinstance(quantity, Quantity)
    assert (quantity.value, quantity.unit.factor) == (10.0, 0.3048)


def test_a_connector_may_give_the_unit_that_its_fmu_does_not(tmp_path: Path, c_fmu: Fmus) -> None:
    plain = tmp_path / "plain.fmu"
    with zipfile.ZipFile(c_fmu("stage")) as old, zipfile.ZipFile(plain, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name.endswith(".xml"):
                content = content.replace(b' unit="s"', b"")
            new.writestr(name, content)
    first = component("a", "s.fmu", "input u Real m", "output y Real Milli-Meter")
    pair = elements(first, component("b", "s.fmu", "input u Real m", "output y Real"))
    ssd = description(pair + connections(connection("a/y", "b/u")))
    system = read(tmp_path, ssd, {"resources/s.fmu": plain})
    (link,) = prepare(system, build_directory=tmp_path).wiring.links
    assert link.factor == pytest.approx(1e-3, rel=1e-15)
    (told,) = problems(tmp_path, ssd, {"resources/s.fmu": c_fmu("stage")})[1:2]
    assert "is in Milli-Meter, in its FMU s" in told or "is in m, in its FMU s" in told


def test_missing_settings_are_told(tmp_path: Path, stages: Files) -> None:
    ssd = description(elements(component("a", "s.fmu", *STAGE)))
    system = read(tmp_path, ssd, stages)
    assert (system.simulation.stop_time, system.simulation.step_size) == (1.0, 0.002)
    assert any("names no stop time: 1 s is taken" in note for note in system.notes)
    assert any("names no step: 0.002 s is taken" in note for note in system.notes)
    step = """<ssd:DefaultExperiment stopTime="5"><ssd:Annotations>
        <ssc:Annotation type="com.opensimulationplatform"><osp:Algorithm
        xmlns:osp="http://opensimulationplatform.com/SSP/OSPAnnotations">
        <osp:FixedStepAlgorithm baseStepSize="0.25"/></osp:Algorithm></ssc:Annotation>
        <ssc:Annotation type="org.example"/></ssd:Annotations></ssd:DefaultExperiment>"""
    system = read(tmp_path, description(elements(component("a", "s.fmu")), step), stages)
    assert (system.simulation.stop_time, system.simulation.step_size) == (5.0, 0.25)
    assert system.notes == ("annotations of type 'org.example' are left out",)
