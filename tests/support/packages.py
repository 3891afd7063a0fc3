"""SSP packages written by hand, as other tools write them."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

ROOT = "http://ssp-standard.org/SSP1/SystemStructure"
SPACES = " ".join(
    f'xmlns:{short}="{ROOT}{name}"'
    for short, name in (
        ("ssc", "Common"),
        ("ssd", "Description"),
        ("ssv", "ParameterValues"),
        ("ssm", "ParameterMapping"),
        ("ssb", "SignalDictionary"),
    )
)
UNITS = """\
<ssd:Units>
  <ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit>
  <ssc:Unit name="Milli-Meter"><ssc:BaseUnit m="1" factor="0.001"/></ssc:Unit>
  <ssc:Unit name="N"><ssc:BaseUnit kg="1" m="1" s="-2"/></ssc:Unit>
  <ssc:Unit name="m/s"><ssc:BaseUnit m="1" s="-1"/></ssc:Unit>
</ssd:Units>"""


def description(system: str, rest: str = "", *, units: str = UNITS) -> str:
    """SystemStructure.ssd with the content of its root system, and what follows that."""
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription {SPACES} '
        f'version="1.0" name="pair">\n<ssd:System name="root">\n{system}\n</ssd:System>\n'
        f"{units}\n{rest}\n</ssd:SystemStructureDescription>\n"
    )


def component(name: str, fmu: str, *variables: str, bindings: str = "") -> str:
    """A component; each variable as ``"input x Real"`` or ``"input x Real m"``."""
    rows = []
    for text in variables:
        kind, variable, type_, *unit = text.split()
        given = f' unit="{unit[0]}"' if unit else ""
        rows.append(
            f'<ssd:Connector name="{variable}" kind="{kind}"><ssc:{type_}{given}/></ssd:Connector>'
        )
    connectors = "<ssd:Connectors>" + "\n".join(rows) + "</ssd:Connectors>" if rows else ""
    return (
        f'<ssd:Component name="{name}" source="resources/{fmu}" '
        f'type="application/x-fmu-sharedlibrary">{connectors}{bindings}</ssd:Component>'
    )


def connection(start: str, end: str, inside: str = "", attributes: str = "") -> str:
    """A connection between ``element/connector``, or ``connector`` of the system itself."""
    ends = []
    for side, text in (("start", start), ("end", end)):
        element, _, name = text.rpartition("/")
        owner = f'{side}Element="{element}" ' if element else ""
        ends.append(f'{owner}{side}Connector="{name}"')
    return f"<ssd:Connection {' '.join(ends)} {attributes}>{inside}</ssd:Connection>"


def parameter_set(values: Mapping[str, str], units: str = "") -> str:
    """An SSV document; each value as ``'Real value="1"'``."""
    rows = "\n".join(
        f'<ssv:Parameter name="{name}"><ssv:{value}/></ssv:Parameter>'
        for name, value in values.items()
    )
    return (
        f'<ssv:ParameterSet {SPACES} version="1.0" name="set"><ssv:Parameters>{rows}'
        f"</ssv:Parameters>{units.replace('ssd:', 'ssv:')}</ssv:ParameterSet>"
    )


def parameter_mapping(entries: Mapping[str, str | tuple[str, str]]) -> str:
    """An SSM document: target → source, or → (source, transformation)."""
    rows = []
    for target, given in entries.items():
        source, inside = given if isinstance(given, tuple) else (given, "")
        rows.append(
            f'<ssm:MappingEntry source="{source}" target="{target}">{inside}</ssm:MappingEntry>'
        )
    return f'<ssm:ParameterMapping {SPACES} version="1.0">{"".join(rows)}</ssm:ParameterMapping>'


def package(path: Path, ssd: str, files: Mapping[str, str | Path]) -> Path:
    """An archive of SystemStructure.ssd and files: texts, or paths of files to be copied."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("SystemStructure.ssd", ssd)
        for name, content in files.items():
            if isinstance(content, Path):
                archive.write(content, name)
            else:
                archive.writestr(name, content)
    return path
