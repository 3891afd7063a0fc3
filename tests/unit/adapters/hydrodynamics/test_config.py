"""What users can write wrongly below `kind: hydrodynamics`, and what they are told."""

import math

import pytest

from m4e_adapters.hydrodynamics.build import frequency_table
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Still
from m4e_adapters.hydrodynamics.geometry.mesh import make_hulls
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document

GOOD = """\
water: {density: 1025, depth: 50}
bodies:
  float:
    shape: {cylinder: {radius: 4.0, draft: 3.0}}
    center_of_gravity: [0, -1.2]
waves: {spectrum: jonswap, significant_height: 2.0, peak_period: 7.0}
"""


def validated(text: str) -> HydrodynamicsConfig:
    return Document.parse(text).validate(HydrodynamicsConfig)


def test_defaults() -> None:
    config = validated("bodies: {b: {shape: {sphere: {radius: 2}}, center_of_gravity: [0, 0]}}")
    assert config.water.density == 1025.0
    assert math.isinf(config.water.depth)
    assert config.waves == Still(spectrum="still")
    assert config.radiation.order is None


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("radius: 4.0", "raduis: 4.0", 4, "did you mean 'radius'?"),
        ("density:", "densety:", 1, "did you mean 'density'?"),
        ("depth: 50", "depth: -50", 1, "greater than 0"),
        ("depth: 50", "depth: .nan", 1, "greater than 0"),
        ("draft: 3.0", "draft: 0", 4, "greater than or equal to 0.0001"),
        ("{cylinder: {radius: 4.0, draft: 3.0}}", "{}", 4, "one shape, got none"),
        ("draft: 3.0}", "draft: 3.0}, sphere: {radius: 1}", 4, "got cylinder and sphere"),
        ("{cylinder: {radius: 4.0, draft: 3.0}}", "{sphere: {radius: 1, center_z: 2}}", 4, "touch"),
        ("draft: 3.0}", "draft: 3.0}, mesh_origin: [0, 1]", 4, "is for mesh files"),
        *(
            ("cylinder: {radius: 4.0, draft: 3.0}", f"revolved: {{profile: {profile}}}", 4, message)
            for profile, message in (
                ("[[4, -3]]", "the profile has 1 of at least two points"),
                ("[]", "the profile has 0 of"),
                ("[[4, 0], [4, -3]]", "the profile goes down"),
                ("[[4, -3], [4, -1], [4, -1], [2, 0]]", "a point twice"),
                ("[[4, 0], [4, 3]]", "the profile is above the water (lowest point at z = 0 m)"),
                ("[[4, -3], [2, -3]]", "has no height"),
                ("[[4, -3], [0, -2], [4, 0]]", "a radius of 0 between its ends"),
                ("[[0, -3], [0, 0]]", "no radius above 0"),
                ("[[-4, -3], [4, 0]]", "greater than or equal to 0"),
                ("[[4, 0, -3], [4, 0, 0]]", "write 2 entries"),
            )
        ),
        ("draft: 3.0}", "draft: 3.0}, scale: 0.001", 4, "'scale' is for mesh files"),
        ("draft: 3.0}", "draft: 3.0}, frame: body", 4, "'frame' is for mesh files"),
        ("draft: 3.0", "draft: 3.0, top_z: -3", 4, "the cylinder has its top at z = -3 m"),
        ("draft: 3.0", "draft: 3.0, top_z: 0.1", 4, "less than or equal to 0"),
        *(
            ("{cylinder: {radius: 4.0, draft: 3.0}}", shape, 4, message)
            for shape, message in (
                ("{horizontal_cylinder: {radius: 1, length: 5, center_z: 1}}", "not touch the"),
                ("{horizontal_cylinder: {radius: 1, length: 5, axis: z}}", "known: x, y"),
                ("{torus: {radius: 5, tube_radius: 1, center_z: 2}}", "does not touch the water"),
                ("{torus: {radius: 5, tube_radius: 5}}", "the torus has no opening"),
                ("{box: {length: 1, width: 1, draft: 1, top_z: -2}}", "the box has its top at z"),
            )
        ),
        ("[0, -1.2]", "[0, -1.2]\n    fixed: true", 2, "all bodies are fixed"),
        ("[0, -1.2]", "[1e300, -1.2]", 5, "less than or equal to 1000000"),
        ("    center_of_gravity: [0, -1.2]\n", "", 3, "missing key 'center_of_gravity'"),
        ("jonswap", "jonswop", 6, "did you mean 'jonswap'?"),
        ("spectrum: jonswap, ", "", 6, "missing key 'spectrum'"),
        ("jonswap,", "jonswap, direction: 90,", 6, "leaves the X-Z plane"),
        ("spectrum: jonswap", "spectrum: pierson_moskowitz, peak_enhancement: 2", 6, "unknown key"),
        ("float:", "my float:", 3, "pattern"),
        ("float:", "wave:", 3, "the name 'wave' has another meaning here"),
        ("float:", "current:", 3, "the name 'current' has another meaning here"),
    ],
)
def test_one_mistake_is_found_where_it_is(old: str, new: str, line: int, message: str) -> None:
    validated(GOOD)
    with pytest.raises(InputError) as caught:
        validated(GOOD.replace(old, new, 1))
    assert message in str(caught.value)
    assert caught.value.problems[0].line == line


def frequencies(text: str) -> list[float]:
    from pathlib import Path

    config = validated(text)
    hulls = make_hulls(config, Path(), progress=lambda _: None)
    return frequency_table(config, hulls).tolist()


def test_frequencies_reach_the_waves_and_the_memory() -> None:
    """The memory decides (the disc of the waterplane has the radius 4 m, k a = 4.5); a sea of short
    waves, 2.5 peak frequencies, adds others after these, and changes none."""
    table = frequencies(GOOD)
    assert table[-1] == pytest.approx(math.sqrt(4.5 * 9.81 / 4.0), rel=1e-9)
    assert frequencies(GOOD.replace("peak_period: 7.0", "peak_period: 9.0")) == table
    longer = frequencies(GOOD.replace("peak_period: 7.0", "peak_period: 4.0"))
    assert longer[: len(table)] == table
    step = longer[-1] - longer[-2]
    assert step == pytest.approx(2 * (table[1] - table[0]), rel=1e-9)
    assert longer[-1] - step < 2.5 * 2 * math.pi / 4.0 <= longer[-1]
    regular = "waves: {spectrum: regular, height: 1, period: 1.8}"
    one = frequencies(GOOD.replace(GOOD[GOOD.index("waves:") :], regular))
    assert one[: len(longer)] == longer[: len(one)]
    assert one[-1] >= 2 * math.pi / 1.8


@pytest.mark.parametrize("depth", [0.0, 4.0, 40.0])
def test_frequencies_of_a_submerged_body_are_those_of_its_size_and_depth(depth: float) -> None:
    """k (a + d) = 4.5, a of the half-ball of its volume: e^(-2kd) of the waves is left at d. The
    waterplane of a closed surface is rounding, not a size."""
    text = GOOD.replace("cylinder: {radius: 4.0, draft: 3.0}", "sphere: {radius: 5, center_z: Z}")
    table = frequencies(text.replace("Z", str(-5.001 - depth)).replace("depth: 50", "depth: deep"))
    size = 2 ** (1 / 3) * 5.0 + depth
    assert table[39] == pytest.approx(math.sqrt(4.5 * 9.81 / size), rel=5e-3)


def test_a_long_table_may_end_before_the_waves() -> None:
    """Above k a = 4.5 the force falls as it does for short waves; a regular wave needs its own."""
    short = GOOD.replace("peak_period: 7.0", "peak_period: 3.0")
    assert frequencies(short + "frequencies: {maximum: 3.4}")[-1] == 3.4
    regular = "waves: {spectrum: regular, height: 1, period: 1.8}\nfrequencies: {maximum: 3.4}"
    with pytest.raises(InputError, match=r"the wave has 3\.491 rad/s"):
        frequencies(GOOD.replace(GOOD[GOOD.index("waves:") :], regular))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("maximum: 2.0", r"up to 2.244 rad/s \(2.5 peak frequencies\)"),
        ("minimum: 0.001", "too low for this water depth"),
        ("minimum: 9", "are not a range"),
        ("minimum: 3, maximum: 2", "is not below maximum"),
    ],
)
def test_frequencies_that_do_not_do(given: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        frequencies(GOOD + f"frequencies: {{{given}}}\n")
    assert caught.value.problems[0].remedy


def test_a_body_in_the_sea_bed_is_told() -> None:
    with pytest.raises(InputError, match=r"the sea bed is at z = -2 m"):
        frequencies(GOOD.replace("depth: 50", "depth: 2"))


def test_an_unknown_spectrum_is_marked_itself() -> None:
    with pytest.raises(InputError) as caught:
        validated(GOOD.replace("jonswap", "jonswop"))
    (problem,) = caught.value.problems
    assert problem.source[problem.column - 1 :][: problem.width] == "jonswop"


def test_spreading_as_a_number_has_a_remedy() -> None:
    text = """\
waves: {spectrum: jonswap, significant_height: 2, peak_period: 8, spreading: 8}
bodies: {a: {shape: {sphere: {radius: 1}}, center_of_gravity: [0, 0]}}
"""
    with pytest.raises(InputError) as caught:
        Document.parse(text).validate(HydrodynamicsConfig)
    (problem,) = caught.value.problems
    assert problem.remedy == "write spreading: {exponent: 8}"
