"""FMUs with C sources: importers compile them, with flags of their own, to the same bits."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu
from support.chains import hanging_chain
from support.fmu_instances import FILES, opened
from support.runtime_programs import every_operation

from m4e_fmi.fmu import build_fmu
from m4e_fmi.multibody import model_program
from m4e_fmi.runtime.compiler import compiler
from m4e_fmi.runtime.platforms import this_platform

STEPS, H = 30, 0.002


def values(path: Path, folder: Path, fmi: str) -> list[list[float]]:
    """All reals after each step, with inputs that change."""
    found = []
    with opened(path, folder, FILES[f"native {fmi}"]) as instance:
        instance.initialise()
        for k in range(STEPS):
            for i, name in enumerate(instance.reals("input")):
                instance.set({name: [(7 * k + i) % 11 / 40.0] * instance.size(name)})
            instance.step(k * H, H)
            found.append(instance.get(instance.reals()))
    return found


def without_binaries(path: Path, target: Path, more: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path) as full, zipfile.ZipFile(target, "w") as emptied:
        for name in full.namelist():
            if not name.startswith("binaries/"):
                emptied.writestr(name, full.read(name))
        for name, content in more.items():
            emptied.writestr(name, content)
    return target


def run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.skipif(shutil.which("cmake") is None, reason="no CMake here, which FMPy calls")
def test_fmpy_compiles_it(tmp_path: Path) -> None:
    """FMPy hands over no flags of ours. The sources are the same in FMI 2.0 and 3.0."""
    program, fmi = model_program(hanging_chain(3)), "2"
    path = build_fmu(program, tmp_path / "chain.fmu", native=True, sources=True, fmi=fmi)
    assert validate_fmu(str(path)) == []
    expected = values(path, tmp_path / "ours", fmi)
    emptied = without_binaries(path, tmp_path / "emptied.fmu", {})
    assert fmpy.supported_platforms(str(emptied)) == ["c-code"]
    run([sys.executable, "-m", "fmpy", "compile", str(emptied)])
    assert values(emptied, tmp_path / "theirs", fmi) == expected


@pytest.mark.skipif(this_platform().name != "x86_64-linux", reason="flags are those of x86-64")
def test_flags_of_the_importer(tmp_path: Path) -> None:
    """Processors that multiply and add in one operation must not: it rounds once instead of twice.

    The compiler may use such operations, and finds no place for one; so the bits are the same.
    """
    fmi = "3"
    path = build_fmu(every_operation(), tmp_path / "m.fmu", native=True, sources=True, fmi=fmi)
    unpacked, library = tmp_path / "unpacked", tmp_path / "library.so"
    fmpy.extract(str(path), str(unpacked))
    description = fmpy.read_model_description(str(path))
    names = description.buildConfigurations[0].sourceFileSets[0].sourceFiles
    flags = ["-O2", "-march=haswell", "-shared", "-fPIC", "-o", str(library)]
    files = (str(unpacked / "sources" / name) for name in names)
    run([*(compiler() or ["cc"]), *flags, *files, "-lm"])
    exported = run(["nm", "-D", "--defined-only", str(library)]).splitlines()
    assert all(line.split()[-1].startswith("fmi") for line in exported)
    code = run(["objdump", "-d", str(library)])
    assert "vmulsd" in code
    assert not re.search(r"\bvfn?m(add|sub)", code)
    if not {"fma", "avx2"} <= set(Path("/proc/cpuinfo").read_text().split()):
        pytest.skip("the library needs a newer processor")
    theirs = {f"binaries/x86_64-linux/{description.modelName}.so": library.read_bytes()}
    compiled = without_binaries(path, tmp_path / "compiled.fmu", theirs)
    assert values(compiled, tmp_path / "theirs", fmi) == values(path, tmp_path / "ours", fmi)
