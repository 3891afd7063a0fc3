"""Systems of waves: spectra, tables, components and records of one's own, spreading, several."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Jonswap, PiersonMoskowitz, Record, Regular, Tma
from m4e_adapters.hydrodynamics.config.waves import AnyWaves
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.spectra import TAPERED, depth_factor
from m4e_adapters.hydrodynamics.seas.system_seas import components_of, lines_on
from m4e_adapters.hydrodynamics.seas.systems import PERIODS, WaveSystem
from m4e_adapters.hydrodynamics.seas.water.kinematics import Components, elevation, wavenumber
from m4e_adapters.hydrodynamics.seas.waves import recorded_wavenumber, relative_spectrum
from m4e_adapters.sea import SeaConfig, sea_program
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.program import Recorder, Variable, evaluated

WIND = {"significant_height": 2.5, "peak_period": 8.0, "seed": 5}


def systems(
    waves: AnyWaves, *, depth: float = math.inf, folder: Path = Path()
) -> tuple[WaveSystem, ...]:
    return wave_systems(waves, depth=depth, gravity=9.81, folder=folder)


def components(waves: AnyWaves, *, depth: float = math.inf, folder: Path = Path()) -> Components:
    return components_of(systems(waves, depth=depth, folder=folder), {})


def from_text(text: str, folder: Path) -> Components:
    config = Document.parse(f"dimensions: 3\nwaves: {text}\n").validate(SeaConfig)
    return components(config.waves, folder=folder)


def height(waves: Components) -> float:
    return 4.0 * math.sqrt(0.5 * float(waves.amplitude @ waves.amplitude))


@pytest.mark.parametrize("depth", [0.5, 12.0, math.inf])
def test_the_recorded_wavenumber_is_the_computed_one(depth: float) -> None:
    recorder = Recorder("r", "r")
    omega = recorder.parameter(Variable("omega", "rad/s", "frequency"))
    number = recorded_wavenumber(omega, depth=depth, gravity=9.81)
    for value in (0.05, 0.3, 1.0, 4.0, 20.0):
        found = evaluated(recorder.tape, [number.index], {"omega": value})[number.index]
        expected = float(wavenumber(np.array(value), depth=depth, gravity=9.81))
        assert found == pytest.approx(expected, rel=1e-13)


def test_bretschneider_is_pierson_moskowitz() -> None:
    one = PiersonMoskowitz(spectrum="pierson_moskowitz", **WIND)
    other = PiersonMoskowitz(spectrum="bretschneider", **WIND)
    np.testing.assert_array_equal(components(one).amplitude, components(other).amplitude)


def test_the_depth_factor_is_the_ratio_of_the_wavenumber_spectra_of_its_authors() -> None:
    """Kitaigorodskii: φ = (k⁻³ ∂k/∂ω)_h/(k⁻³ ∂k/∂ω)_∞; differences leave 1e-8."""
    omega = np.linspace(0.3, 4.0, 30)
    step = 1e-5

    def ratio(depth: float) -> np.ndarray:
        k, after, before = (
            wavenumber(omega + d, depth=depth, gravity=9.81) for d in (0.0, step, -step)
        )
        return k**-3 * (after - before) / (2 * step)

    expected = ratio(9.0) / ratio(math.inf)
    assert expected.min() < 0.1
    assert expected.max() > 0.99
    np.testing.assert_allclose(depth_factor(omega, depth=9.0, gravity=9.81), expected, rtol=1e-7)


def test_tma_is_jonswap_in_deep_water_and_has_its_height_in_shallow() -> None:
    deep = components(Tma(spectrum="tma", **WIND), depth=2000.0)
    same = components(Jonswap(spectrum="jonswap", **WIND))
    np.testing.assert_allclose(deep.amplitude, same.amplitude, rtol=1e-9)
    shallow = components(Tma(spectrum="tma", **WIND), depth=8.0)
    assert height(shallow) == pytest.approx(2.5, rel=1e-12)
    assert np.sum(shallow.amplitude**2 * shallow.omega) > 1.1 * np.sum(
        same.amplitude**2 * same.omega
    )
    with pytest.raises(InputError, match=r"TMA sea needs a depth\n.*give water.depth"):
        components(Tma(spectrum="tma", **WIND))


def write_jonswap(path: Path, *, hertz: bool) -> None:
    """The density of Hs 2.5 m, Tp 8 s, to 1e-4 between its rows."""
    peak = 2 * math.pi / 8.0
    ratio = np.concatenate([np.linspace(0.4, 2.0, 800), np.geomspace(2.0, 12.0, 201)[1:]])
    form = np.array([relative_spectrum(r, 3.3) for r in ratio.tolist()])
    omega, density = ratio * peak, form * 2.5**2 / 16 / np.trapezoid(form, ratio * peak)
    turn = 2 * math.pi if hertz else 1.0
    rows = "\n".join(
        f"{w / turn!r},{s * turn!r}" for w, s in zip(omega.tolist(), density.tolist(), strict=True)
    )
    path.write_text(f"{'frequency' if hertz else 'omega'},density\n{rows}\n")


def test_a_spectrum_in_a_file_has_its_moments_over_either_frequency(tmp_path: Path) -> None:
    """T01 and T02 are those of the rows within 0.5 %, m0 exactly."""
    write_jonswap(tmp_path / "omega.csv", hertz=False)
    write_jonswap(tmp_path / "hertz.csv", hertz=True)
    found = [
        from_text(f"{{spectrum: table, file: {name}.csv, seed: 4}}", tmp_path)
        for name in ("omega", "hertz")
    ]
    np.testing.assert_allclose(found[0].amplitude, found[1].amplitude, rtol=1e-6)
    assert height(found[0]) == pytest.approx(2.5, rel=1e-6)
    omega, density = np.loadtxt(tmp_path / "omega.csv", delimiter=",", skiprows=1, unpack=True)
    energy = 0.5 * found[0].amplitude ** 2
    for k, limit in ((1, 0.005), (2, 0.01)):
        moment = np.trapezoid(omega**k * density, omega)
        assert float(energy @ found[0].omega ** k) == pytest.approx(moment, rel=limit)
    scaled = from_text("{spectrum: table, file: omega.csv, significant_height: 4}", tmp_path)
    assert height(scaled) == pytest.approx(4.0, rel=1e-12)


def test_a_spectrum_of_two_peaks_has_no_energy_between_them(tmp_path: Path) -> None:
    rows = "0,0\n0.4,0\n0.5,2\n0.6,0\n1.0,0\n1.2,1\n1.4,0\n2,0\n"
    (tmp_path / "s.csv").write_text(f"omega,density\n{rows}")
    found = from_text("{spectrum: table, file: s.csv}", tmp_path)
    assert height(found) == pytest.approx(4 * math.sqrt(0.2 + 0.2), rel=1e-12)
    low = found.omega < 0.8
    assert height(found) == pytest.approx(math.sqrt(2) * 4 * math.sqrt(0.2), rel=1e-12)
    assert 0.5 * np.sum(found.amplitude[low] ** 2) == pytest.approx(0.2, rel=1e-9)


def test_components_of_ones_own_by_list_and_by_file(tmp_path: Path) -> None:
    listed = from_text(
        "{spectrum: components, direction: 10, seed: 2, components: [{amplitude: 1, period: 9, "
        "phase: 0.5}, {amplitude: 0.4, omega: 1.5, direction: 40}]}",
        tmp_path,
    )
    np.testing.assert_allclose(listed.omega, [2 * math.pi / 9, 1.5])
    np.testing.assert_allclose(listed.amplitude, [1.0, 0.4])
    np.testing.assert_allclose(np.degrees(listed.direction), [10.0, 40.0])
    assert listed.phase[0] == 0.5
    drawn = np.random.Generator(np.random.PCG64(2)).uniform(0.0, 2 * math.pi, 2).tolist()
    assert listed.phase[1] == drawn[1]
    (tmp_path / "c.csv").write_text(
        f"omega,amplitude,direction,phase\n{2 * math.pi / 9!r},1,10,0.5\n1.5,0.4,40,{drawn[1]!r}\n"
    )
    read = from_text("{spectrum: components, direction: 10, file: c.csv}", tmp_path)
    for name in ("omega", "amplitude", "direction", "phase"):
        np.testing.assert_allclose(getattr(read, name), getattr(listed, name), rtol=1e-15)


@pytest.mark.parametrize("exponent", [2.0, 10.0, 75.0])
def test_spreading_is_recovered(exponent: float) -> None:
    """Mean direction within 2°, spreading √(2/(1 + s)) within 5 %, for ten seeds, and of the
    parts around the peak alone within twice that."""
    for seed in range(10):
        section = Jonswap.model_validate(
            {"spectrum": "jonswap", **WIND, "seed": seed, "direction": 30.0,
             "spreading": {"exponent": exponent}}
        )  # fmt: skip
        waves = components(section)
        for part, times in ((slice(None), 1), (slice(60, 120), 2)):
            energy = waves.amplitude[part] ** 2
            first = np.sum(energy * np.exp(1j * waves.direction[part])) / energy.sum()
            spread = math.sqrt(2 * (1 - abs(first)))
            assert np.degrees(np.angle(first)) == pytest.approx(30.0, abs=2.0 * times)
            assert spread == pytest.approx(math.sqrt(2 / (1 + exponent)), rel=0.05 * times)


def test_spreading_leaves_frequencies_and_phases() -> None:
    plain = components(Jonswap(spectrum="jonswap", **WIND))
    text = {"spectrum": "jonswap", **WIND, "spreading": {"exponent": 8}}
    short = components(Jonswap.model_validate(text))
    for name in ("omega", "amplitude", "phase"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(short, name))
    assert not plain.direction.any()
    assert len(np.unique(short.omega)) == len(np.unique(short.direction)) == 300


def test_random_amplitudes_are_rayleighs_and_those_of_the_seed() -> None:
    """Squares over the fixed ones are exponential: mean 1 ± 5/√900, variance 1."""
    ratios = []
    for seed in (1, 2, 3):
        fixed, random = (
            components(Jonswap.model_validate(
                {"spectrum": "jonswap", **WIND, "seed": seed, "amplitudes": how}
            ))
            for how in ("fixed", "random")
        )  # fmt: skip
        ratios.append((random.amplitude / fixed.amplitude) ** 2)
        np.testing.assert_array_equal(random.phase, fixed.phase)
    found = np.concatenate(ratios)
    assert found.mean() == pytest.approx(1.0, abs=5 / math.sqrt(900))
    assert found.var() == pytest.approx(1.0, abs=5 * math.sqrt(8 / 900))


def test_parameters_of_one_system_keep_their_names_and_several_are_numbered() -> None:
    one = Regular(spectrum="regular", height=1.0, period=12.0)
    two = Jonswap.model_validate({"spectrum": "jonswap", **WIND, "components": 10})
    names = []
    for waves in (one, (one, two)):
        recorder = Recorder("r", "r")
        for system in systems(waves):
            system.record(recorder, in_space=True)
        names.append([v.name for v in recorder.variables("parameters")])
    assert names[0] == [
        "wave.height", "wave.period", "wave.phase[1]", "wave.direction", "wave.ramp_time",
    ]  # fmt: skip
    assert names[1][:5] == [name.replace("wave", "wave[1]") for name in names[0]]
    assert names[1][5:9] == [
        "wave[2].significant_height", "wave[2].peak_period", "wave[2].peak_enhancement",
        "wave[2].phase[1]",
    ]  # fmt: skip
    both = components((one, two))
    apart = [components(one), components(two)]
    t = np.linspace(0.0, 50.0, 101)
    total = elevation(apart[0], t, 3.0) + elevation(apart[1], t, 3.0)
    np.testing.assert_allclose(elevation(both, t, 3.0), total, atol=1e-14)


def write_record(path: Path, *, interval: float, start: float, place: float) -> Components:
    """Ten minutes of a JONSWAP sea at a place on the x axis, and the sea."""
    sea = components(Jonswap(spectrum="jonswap", **WIND))
    t = start + interval * np.arange(round(600 / interval))
    rows = "\n".join(
        f"{a:.6f},{b!r}" for a, b in zip(t.tolist(), elevation(sea, t, place).tolist(), strict=True)
    )
    path.write_text(f"time,elevation\n{rows}\n")
    return sea


def test_a_record_is_reproduced_at_its_place_and_50_m_on(tmp_path: Path) -> None:
    """Within 1e-3 of its deviation, between its rows too. The shortest waves, of 12 peak
    frequencies, travel 50 m in 96 s: there from a fifth of the record on."""
    sea = write_record(tmp_path / "r.csv", interval=0.25, start=20.0, place=12.0)
    found = components(Record(spectrum="record", file="r.csv", place=(12.0,)), folder=tmp_path)
    deviation = height(sea) / 4
    t = np.linspace(20.0 + 600 * (TAPERED + 0.01), 620.0 - 600 * (TAPERED + 0.01), 3001)
    there = elevation(found, t, 12.0) - elevation(sea, t, 12.0)
    assert np.abs(there).max() < 1e-3 * deviation
    late = t[t > 20.0 + 120.0]
    on = elevation(found, late[:-400], 62.0) - elevation(sea, late[:-400], 62.0)
    assert np.abs(on).max() < 1e-3 * deviation


def test_a_record_of_another_direction_is_at_its_place_still(tmp_path: Path) -> None:
    sea = write_record(tmp_path / "r.csv", interval=0.25, start=0.0, place=0.0)
    text = "{spectrum: record, file: r.csv, place: [30, -8], direction: 70}"
    found = from_text(text, tmp_path)
    t = np.linspace(40.0, 560.0, 501)
    error = elevation(found, t, 30.0, -8.0) - elevation(sea, t, 0.0)
    assert np.abs(error).max() < 1e-3 * height(sea) / 4
    config = Document.parse(f"dimensions: 3\nwaves: {text}\npoints: {{p: [30, -8, 0]}}\n").validate(
        SeaConfig
    )
    program = sea_program(config, name="s", folder=tmp_path)
    index = program.results[[v.name for v in program.outputs].index("p.elevation")]
    for turned in (math.radians(70.0), 1.0):  # the place keeps its record when the waves turn
        known = {**{v.name: v.start for v in program.parameters}, "wave.direction": turned}
        (value,) = evaluated(program.tape, [index], {**known, "time": 200.0}).values()
        assert value == pytest.approx(float(elevation(sea, 200.0, 0.0)), abs=1e-3)


def test_doubts_about_a_record_are_told(tmp_path: Path) -> None:
    """A mean, and steps of 1 s in a sea of 4 s."""
    sea = components(Jonswap(spectrum="jonswap", significant_height=1.0, peak_period=4.0))
    t = np.arange(300.0)
    rows = "\n".join(f"{a},{b + 0.1}" for a, b in zip(t, elevation(sea, t, 0.0), strict=True))
    (tmp_path / "r.csv").write_text(f"time,elevation\n{rows}\n")
    (system,) = systems(Record(spectrum="record", file="r.csv"), folder=tmp_path)
    mean, coarse = system.doubts({})
    assert "the mean of r.csv, 0.0986 m, is left out" in mean
    assert "% of its energy in waves of less than 2.5 rows" in coarse


def recorded(folder: Path, elevation: np.ndarray, *, start: float = 0.0) -> WaveSystem:
    """A record with rows in steps of 0.5 s."""
    rows = "".join(f"{start + 0.5 * k},{v!r}\n" for k, v in enumerate(elevation.tolist()))
    (folder / "r.csv").write_text(f"time,elevation\n{rows}")
    (system,) = systems(Record(spectrum="record", file="r.csv"), folder=folder)
    return system


def doubts_of(folder: Path, elevation: np.ndarray) -> list[str]:
    """Doubts about a record with rows in steps of 0.5 s."""
    return recorded(folder, elevation).doubts({})


def measured(count: int = 2400) -> np.ndarray:
    """Rows (n,) [m] of a sea of Hs 2.5 m, in steps of 0.5 s."""
    sea = components(Jonswap(spectrum="jonswap", **WIND))
    return elevation(sea, 0.5 * np.arange(count), 0.0)


def test_the_ends_of_a_record_are_told_with_the_energy_that_they_lose(tmp_path: Path) -> None:
    """Half cosines leave 3/8 of the energy of two twentieths. Every record has them: no warning."""
    sine = np.sin(2 * math.pi * 0.05 * np.arange(2400))
    system = recorded(tmp_path, sine)
    (told,) = system.notes()
    assert [*lines_on([system])] == [told]
    assert "r.csv is 1200 s long, repeats itself, and is tapered to 0 for 60 s at each" in told
    assert "takes 6.3 % of its energy" in told  # 2 times 0.05 times 5/8 is 6.25 %
    assert told.endswith("take t = 60 to 1140 s")


def test_a_record_that_begins_at_another_time_is_told(tmp_path: Path) -> None:
    """At t = 0 it is 5 times 1200 s - 5000 s = 1000 s after its first row."""
    system = recorded(tmp_path, measured(), start=5000.0)
    (later,), (ends,) = system.doubts({}), system.notes()
    assert [*lines_on([system])] == [ends, f"warning: {later}"]
    assert "begins at t = 5000 s and repeats itself: at t = 0 s the sea is that of 1000 s" in later
    assert ends.endswith("take t = 5060 to 6140 s")


def test_spikes_and_values_that_stand_still_are_told(tmp_path: Path) -> None:
    sea = measured()
    assert doubts_of(tmp_path, sea) == []
    spiked = sea.copy()
    spiked[1000] = 12.0
    assert doubts_of(tmp_path, spiked)[0].startswith(
        "r.csv has a row beyond 6 standard deviations, the farthest 12 m at t = 500 s"
    )
    stuck = sea.copy()
    stuck[1200:1260] = 0.25
    assert "is 0.25 m from t = 600 to 629.5 s" in doubts_of(tmp_path, stuck)[0]
    flat_crests = np.clip(sea, -0.6, 0.6)
    assert not any("longer than a wave" in text for text in doubts_of(tmp_path, flat_crests))


def test_doubts_follow_the_values_of_parameters() -> None:
    (system,) = systems(Jonswap(spectrum="jonswap", **WIND))
    assert system.doubts({}) == []
    (told,) = system.doubts({"wave.significant_height": 7.0})
    assert "Hs 7 m, Tp 8 s" in told
    (wave,) = systems(Regular(spectrum="regular", height=1.0, period=8.0))
    assert wave.doubts({}) == []
    (told,) = wave.doubts({"wave.period": 2.0})
    assert "waves of a period of 2 s break" in told


def test_another_peak_period_keeps_the_frequencies() -> None:
    (system,) = systems(Jonswap(spectrum="jonswap", **WIND))
    longest = PERIODS[1] * 8.0
    omega, amplitudes, _ = system.known({"wave.peak_period": longest})
    np.testing.assert_array_equal(omega, system.omega)
    assert 4 * math.sqrt(0.5 * float(amplitudes @ amplitudes)) == pytest.approx(2.5)
    peak = omega[np.argmax(amplitudes**2 / np.gradient(omega))]
    assert 2 * math.pi / peak == pytest.approx(longest, rel=0.1)


GOOD = {
    "s.csv": "omega,density\n0.3,0\n0.6,1\n0.9,0\n",
    "c.csv": "period,amplitude\n9,1\n5,0.2\n",
    "r.csv": "time,elevation\n" + "".join(f"{0.5 * k},{k % 5}\n" for k in range(40)),
}
LATE = GOOD["r.csv"][GOOD["r.csv"].index("\n9.0") :]
TABLE = "{spectrum: table, file: s.csv}"
FILE = "{spectrum: components, file: c.csv}"
RECORD = "{spectrum: record, file: r.csv}"


@pytest.mark.parametrize(
    ("waves", "old", "new", "place", "message"),
    [
        (TABLE, "omega,", "w,", "s.csv:1", "no column 'omega'"),
        (TABLE, "omega,density", "omega,frequency", "s.csv:", "both a column 'omega' and"),
        (TABLE, "0.6,1", "0.2,1", "s.csv:3", "frequency 0.2 is not above 0.3"),
        (TABLE, "0.6,1", "0.6,-1", "s.csv:3", "a density of -1 is negative"),
        (TABLE, "0.6,1", "0.6,0", "s.csv:2", "all densities are 0"),
        (TABLE, "0.9,0\n", "", "s.csv", "expected 3 to 10000 rows, got 2"),
        (TABLE, "0.6,1", "0.6,x", "s.csv:3", "expected a finite number in column 'density'"),
        (TABLE, "0.3,0", "-0.3,0", "s.csv:2", "a frequency of -0.3 is negative"),
        (FILE, "9,1", "9,-1", "c.csv:2", "amplitude -1 is not positive"),
        (FILE, "5,0.2", "0,0.2", "c.csv:3", "period 0 is not positive"),
        (FILE, "period,", "length,", "c.csv:1", "no column 'period'"),
        (RECORD, "\n5.0,0", "\n5.0,nan", "r.csv:12", "expected a finite number in column 'elev"),
        (RECORD, "\n5.0,0", "\n5.0,", "r.csv:12", "fill it, or give the part before or after it"),
        (RECORD, "\n5.0,0", "\n4.5,0", "r.csv:12", "time 4.5 s is not after 4.5 s"),
        (RECORD, "\n5.0,0", "", "r.csv:12", "a gap of 1 s, between rows 0.5 s apart"),
        (RECORD, "\n5.0,0", "\n5.1,0", "r.csv:12", "times are not in equal steps: 5.1 s"),
        (RECORD, LATE, "", "r.csv", "expected 32 to 10000 rows, got 18"),
    ],
)  # fmt: skip
def test_files_that_are_wrong(
    tmp_path: Path, waves: str, old: str, new: str, place: str, message: str
) -> None:
    for name, text in GOOD.items():
        (tmp_path / name).write_text(text)
    assert len(from_text(waves, tmp_path).omega) > 0
    name = place.partition(":")[0]
    assert old in GOOD[name]
    (tmp_path / name).write_text(GOOD[name].replace(old, new))
    with pytest.raises(InputError) as caught:
        from_text(waves, tmp_path)
    assert f"{tmp_path / place}" in str(caught.value)
    assert message in str(caught.value)


def test_a_constant_record_and_a_missing_file_are_refused(tmp_path: Path) -> None:
    rows = "".join(f"{k},2\n" for k in range(40))
    (tmp_path / "r.csv").write_text(f"time,elevation\n{rows}")
    with pytest.raises(InputError, match=r"r\.csv:2.*the elevation never changes"):
        from_text(RECORD, tmp_path)
    with pytest.raises(InputError, match=r"no such file\n.*did you mean 'r.csv'"):
        from_text("{spectrum: record, file: q.csv}", tmp_path)


@pytest.mark.parametrize(
    ("waves", "line", "message", "remedy"),
    [
        ("{spectrum: jonswap, significant_height: 2, peak_period: 7, spreading: {exponent: 5}}",
         1, "'spreading' leaves the X-Z plane", "remove it, or 'dimensions: 3'"),
        ("{spectrum: regular, height: 1, period: 5, direction: 40}",
         1, "wave direction 40 deg leaves", "write 0"),
        ("[{spectrum: regular, height: 1, period: 5}, {spectrum: regular, height: 1, period: 9, "
         "direction: 180}]", 1, "all travel in one direction", "write the same everywhere"),
        ("{spectrum: components, components: [{amplitude: 1, period: 9, direction: 5}]}",
         1, "wave direction 5 deg is not that of the others", "remove it"),
        ("{spectrum: components, components: [{amplitude: 1, period: 9, omega: 1}]}",
         1, "a 'period' [s] or an 'omega' [rad/s]", "write one"),
        ("{spectrum: components, components: []}", 1, "0 components, expected 1 to 1000", ""),
        ("{spectrum: components}", 1, "here or in a file", "write one of the two"),
        ("[]", 1, "a list of 0 systems of waves", "write {spectrum: still}"),
        ("[{spectrum: still}]", 1, "still water is no system", "leave it out"),
        ("{spectrum: table}", 1, "missing key 'file'", "add"),
        ("{spectrum: record, file: r.csv, place: [1, 2, 3]}", 1, "too many entries", "2 entries"),
        ("{spectrum: tmaa, significant_height: 1, peak_period: 5}", 1, "unknown spectrum", "tma"),
        ("{spectrum: jonswap, significant_height: 2, peak_period: 7, amplitudes: some}",
         1, "unknown amplitudes 'some'", ""),
    ],
)  # fmt: skip
def test_sections_that_are_wrong(waves: str, line: int, message: str, remedy: str) -> None:
    with pytest.raises(InputError) as caught:
        Document.parse(f"waves: {waves}\n").validate(SeaConfig)
    (problem,) = caught.value.problems
    assert problem.line == line
    assert message in problem.message
    assert remedy in problem.remedy
