"""The physics of external forces, without FMI: moorings, hydrodynamics, control.

Each adapter describes its input (pydantic sections), computes, and says with `requirements()` what
it needs of the machine. Adapters are found through the entry-point group `m4e_fmi.adapters`. May
import m4e_fmi's `errors`, `document`, `units`, `program`, and how it reads, writes and hashes files
(`files_read`, `writing`, `code_hash`), and nothing else of it.
"""
