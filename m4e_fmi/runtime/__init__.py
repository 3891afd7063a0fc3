"""Running a program: the C library, and integrators in plain Python for use without it.

`src/` holds the library (start with `m4e.h`); `compiler` builds and `library` finds it; `engine`
runs a program, `kernel` writes its blocks in C. `declarations` and `integrators` use the standard
library only, because they also travel inside FMUs. This package may import `program` and `errors`.
"""

from m4e_fmi.runtime.integrators import DormandPrince, IntegrationError, RungeKutta

__all__ = ["DormandPrince", "IntegrationError", "RungeKutta"]
