"""Checkpoints: the state of a whole run in one file, from which another process goes on.

`encoding` turns dataclasses, arrays and containers into JSON and raw bytes, and back by their type
hints; `container` is the file with its checksum; `identity` tells what must be the same in a run
that goes on, and `state` is what a run can return to. When checkpoints are taken, and how a run
begins at one: `m4e_fmi.cosim.master.checkpoints` and `m4e_fmi.cosim.master.resume`. Start reading
at `state`.
"""
