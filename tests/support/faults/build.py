"""FMUs in which a fault can be armed from outside (faulty.c), of FMI 1.0, 2.0 and 3.0."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import fmpy
from support.c_fmus.build import HERE as HONEST
from support.c_fmus.build import MODELS, OPTIONS, describe
from support.c_fmus.compiled import FMI_HEADERS, archived
from support.c_fmus.versions import description_1, scalars_3

HERE = Path(__file__).parent
SHELLS = {1: "shell_1.c", 2: "shell.c", 3: "shell_3.c"}


def build_faulty(version: int, name: str, folder: Path) -> Path:
    """The FMU ``model+option+option`` of MODELS and OPTIONS with faults, in `folder`."""
    model, *options = name.split("+")
    source, variables = MODELS[model]
    stem = "_".join(["faulty", model, *options, f"fmi{version}"])
    inputs_from = next((k for k, v in enumerate(variables) if v.causality == "input"), 0)
    flags = [f'-DMODEL="{source}"', f"-DIDENTIFIER={stem}", f"-DINPUTS_FROM={inputs_from}"]
    flags += [f"-DFMI={version}", *(f"-D{OPTIONS[option][0]}" for option in options)]
    library = folder / (stem + fmpy.sharedLibraryExtension)
    _compile(version, flags, folder, stem, library)
    text = {1: description_1, 2: describe, 3: scalars_3}[version](stem, variables, options)
    platform = fmpy.platform_tuple if version == 3 else fmpy.platform
    return archived(library, text, platform)


def _compile(version: int, flags: list[str], folder: Path, stem: str, library: Path) -> None:
    """The honest functions get other names, and those of faulty.c call them."""
    include = [f"-I{FMI_HEADERS}", f"-I{HONEST}"]
    cc = ["cc", "-O1", "-fPIC", "-w", "-c", *include, *flags]
    honest, faulty, absent = (
        folder / f"{stem}_{part}.o" for part in ("honest", "faulty", "absent")
    )
    subprocess.run([*cc, HONEST / SHELLS[version], "-o", honest], check=True)
    subprocess.run([*cc, HERE / "faulty.c", "-o", faulty], check=True)
    listed = subprocess.run(["nm", "--undefined-only", faulty], stdout=subprocess.PIPE, check=True)
    prefix = f"{stem}_" if version == 1 else ""
    renamed = [
        f"--redefine-sym={prefix}{found}=honest_{found}"
        for found in re.findall(r" U honest_(\w+)", listed.stdout.decode())
    ]
    subprocess.run(["objcopy", *renamed, honest], check=True)
    objects = [faulty, honest]
    if version == 3:
        subprocess.run([*cc, HONEST / "absent_3.c", "-o", absent], check=True)
        objects.append(absent)
    subprocess.run(
        ["cc", "-shared", *objects, "-lstdc++", "-lm", "-lpthread", "-o", library], check=True
    )
