"""Names that SSP files consist of: namespaces, files, types of annotations."""

from __future__ import annotations

SSD_FILE = "SystemStructure.ssd"
PARAMETER_FILE = "resources/{}.ssv"
VERSION = "1.0"
_ROOT = "http://ssp-standard.org/SSP1/SystemStructure"
SSC = f"{{{_ROOT}Common}}"
SSD = f"{{{_ROOT}Description}}"
SSV = f"{{{_ROOT}ParameterValues}}"
SSM = f"{{{_ROOT}ParameterMapping}}"
SCHEMAS = {
    SSD: "SystemStructureDescription.xsd",
    SSV: "SystemStructureParameterValues.xsd",
    SSM: "SystemStructureParameterMapping.xsd",
}
"""Schema of each kind of file, among those that FMPy carries."""

FMU_TYPES = ("application/x-fmu-sharedlibrary", "application/x-fmu")
PARAMETER_SET_TYPE = "application/x-ssp-parameter-set"
PARAMETER_MAPPING_TYPE = "application/x-ssp-parameter-mapping"

OWN = "m4e_fmi"
"""Type of our annotations, whose content is JSON."""
OSP = "com.opensimulationplatform"
"""Type of the annotations of the Open Simulation Platform, which name a step."""
OSP_SPACE = "{http://opensimulationplatform.com/SSP/OSPAnnotations}"
GRAPHICS = ("ElementGeometry", "ConnectorGeometry", "ConnectionGeometry", "SystemGeometry",
            "GraphicalElements")  # fmt: skip
