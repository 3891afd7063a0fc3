"""The libraries of all platforms: which are used, and that each is what its platform loads."""

from __future__ import annotations

import re
import struct
import subprocess
from pathlib import Path

import pytest
from support.libraries import (
    LC_CODE_SIGNATURE,
    LC_ID_DYLIB,
    MachO,
    dll_exports,
    mach_o,
    universal_parts,
)

from m4e_fmi.fmu.export.native_fmu import shell_binaries, universal
from m4e_fmi.runtime import platforms
from m4e_fmi.runtime.platforms import PLATFORMS, packaged, this_platform

OLDEST_GLIBC = (2, 17)
DYLIB = 6
OF_THE_LINKER = {"__dso_handle", "_mh_dylib_header"}


def library(platform: str, name: str = "fmi") -> bytes:
    path = packaged(name, PLATFORMS[platform])
    if path is None:
        pytest.skip(f"no library for {platform} here: make platforms")
    return path.read_bytes()


def names_of_this_machine() -> set[str]:
    """What the library that this machine loads exports."""
    [content] = [c for n, c in shell_binaries("f", fmi="3").items() if this_platform().name in n]
    return set(re.findall(r"\bfmi[23][A-Z]\w+", content.decode("latin-1")))


@pytest.fixture
def invented(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, bytes]:
    """A library for every platform, small and without sense."""
    monkeypatch.setattr(platforms, "FOLDER", tmp_path)
    processors = {"x86_64": 0x01000007, "aarch64": 0x0100000C}
    made = {}
    for name, platform in PLATFORMS.items():
        file = tmp_path / platforms.library_file("fmi", platform)
        file.parent.mkdir()
        header = struct.pack("<3I", 0xFEEDFACF, processors[name.split("-")[0]], 3)
        file.write_bytes(header + name.encode())
        file.with_name(platforms.DIGEST).write_text(platforms.source_digest())
        made[name] = file.read_bytes()
    return made


def test_a_library_of_other_sources_is_none(invented: dict[str, bytes]) -> None:
    here = this_platform()
    file = packaged("fmi", here)
    assert file
    assert file.read_bytes() == invented[here.name]
    assert packaged("runtime", here) is None
    for digest in ("of other sources", None):
        file.with_name(platforms.DIGEST).unlink()
        if digest:
            file.with_name(platforms.DIGEST).write_text(digest)
        assert packaged("fmi", here) is None


def test_folders_of_libraries(invented: dict[str, bytes]) -> None:
    files = shell_binaries("f")
    linux = "aarch64-linux" if this_platform().name == "aarch64-linux" else "x86_64-linux"
    assert files["binaries/linux64/f.so"] == invented[linux]
    assert files["binaries/win64/f.dll"] == invented["x86_64-windows"]
    parts = list(universal_parts(files["binaries/darwin64/f.dylib"]))
    assert parts == [invented["x86_64-darwin"], invented["aarch64-darwin"]]
    assert len(files) == 3
    files = shell_binaries("f", fmi="3")
    assert files == {f"binaries/{p.name}/f{p.suffix}": invented[p.name] for p in PLATFORMS.values()}


def test_wrong_platforms_and_libraries_are_refused() -> None:
    assert platforms.chosen("all") == list(PLATFORMS.values())
    with pytest.raises(ValueError, match="no platforms: win64"):
        platforms.chosen("x86_64-linux,win64")
    with pytest.raises(ValueError, match="Mach-O"):
        universal([b"\x7fELF" + bytes(20), b"\x7fELF" + bytes(20)])


@pytest.mark.parametrize("name", ["x86_64-linux", "aarch64-linux"])
def test_linux_libraries_need_an_old_glibc_only(name: str, tmp_path: Path) -> None:
    content = library(name)
    assert content[:5] == b"\x7fELF\x02"
    assert struct.unpack_from("<H", content, 18) == ({"x86_64": 62, "aarch64": 183}[name[:-6]],)
    needed = re.findall(rb"GLIBC_(\d+)\.(\d+)", content)
    assert needed
    assert max((int(a), int(b)) for a, b in needed) <= OLDEST_GLIBC
    file = tmp_path / "library.so"
    file.write_bytes(content)
    listed = subprocess.run(
        ["nm", "-D", "--defined-only", str(file)], capture_output=True, text=True, check=True
    )
    assert {line.split()[-1] for line in listed.stdout.splitlines()} == names_of_this_machine()


def test_the_windows_library_exports_fmi_only() -> None:
    assert dll_exports(library("x86_64-windows")) == names_of_this_machine()


def test_the_universal_library_of_macos() -> None:
    """Structure only: nothing here can run it."""
    for name in ("x86_64-darwin", "aarch64-darwin"):
        library(name)
    parts = universal_parts(shell_binaries("f")["binaries/darwin64/f.dylib"])
    found = {part.processor: part for part in map(mach_o, parts)}
    assert set(found) == {"x86_64", "aarch64"}
    for part in found.values():
        check_dylib(part)
    # Apple's processors load signed code only
    assert LC_CODE_SIGNATURE in found["aarch64"].commands


def check_dylib(part: MachO) -> None:
    assert part.kind == DYLIB
    assert LC_ID_DYLIB in part.commands
    assert part.exported - OF_THE_LINKER == names_of_this_machine()
