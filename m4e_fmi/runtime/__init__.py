"""What runs a program: the C library, and an integrator in plain Python where there is none.

`src/` holds the library (start with `m4e.h`); `compiler` builds and `library` finds it; `engine`
runs a program, `kernel` writes its blocks in C, `integrator` cuts an integration into calls.
`declarations` and `dormand_prince` use the standard library only, because they also travel inside
FMUs. This package may import `program` and `errors`.
"""

from m4e_fmi.runtime.dormand_prince import DormandPrince, IntegrationError

__all__ = ["DormandPrince", "IntegrationError"]
