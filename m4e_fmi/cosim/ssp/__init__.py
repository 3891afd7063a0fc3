"""Systems as SSP 1.0 packages: a ZIP archive with SystemStructure.ssd and the FMUs.

Start reading at `read` and `write`. `package` opens the archive and its XML files, and has their
units; `elements` is the tree of systems and components in it, and what flows between them;
`parameters` are the start values.
Source: Modelica Association, System Structure and Parameterization 1.0.1, 2022.
"""

from m4e_fmi.cosim.ssp.package import unpack_member
from m4e_fmi.cosim.ssp.parameters import read_parameter_set
from m4e_fmi.cosim.ssp.read import read_ssp
from m4e_fmi.cosim.ssp.write import write_ssp

__all__ = ["read_parameter_set", "read_ssp", "unpack_member", "write_ssp"]
