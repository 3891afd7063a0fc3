"""Running a program: the C library.

`src/` holds the library (start with `m4e.h`); `compiler` builds and `library` finds it; `engine`
runs a program, `kernel` writes its blocks in C. `declarations` uses the standard library only,
because it also travels inside FMUs. This package may import `program` and `errors`.
"""
