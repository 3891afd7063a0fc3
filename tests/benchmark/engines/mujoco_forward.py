"""MuJoCo: mj_forward of the wheel's library, called from C; constraints and sensors are off."""

from __future__ import annotations

import ctypes
import functools
import importlib.util
from collections.abc import Sequence
from ctypes import c_char_p, c_int, c_void_p
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from benchmark.engine import Prepared, UnavailableError
from benchmark.native_code import (
    BUILD,
    NATIVE,
    Floats,
    address,
    call_rates,
    compiled,
    interleaved,
    native_batch,
)
from benchmark.systems import GRAVITY, GROUND, System, Vector
from benchmark.timing import cpu_seconds


@functools.cache
def library() -> ctypes.CDLL:
    """The compiled C functions over the wheel. Raises UnavailableError."""
    found = importlib.util.find_spec("mujoco")
    if found is None or found.origin is None:
        raise UnavailableError("the package mujoco is not installed")
    folder = Path(found.origin).parent
    shared = next(iter(sorted(folder.glob("libmujoco.*"))), None)
    if shared is None:
        raise UnavailableError("the package mujoco brings no C library")
    options = ["-O2", f"-I{folder / 'include'}", str(shared), f"-Wl,-rpath,{folder}"]
    made = compiled(NATIVE / "mujoco.c", options)
    made.mujoco_new.restype = c_void_p
    made.mujoco_new.argtypes = [c_char_p, c_void_p, c_void_p, c_char_p, c_int]
    made.mujoco_set.argtypes = [c_void_p, c_void_p]
    made.mujoco_select.argtypes = [c_void_p]
    made.mujoco_size.argtypes = [c_void_p]
    return made


def new(system: System) -> int:
    """Address of a model of `system` that is kept for good."""
    BUILD.mkdir(parents=True, exist_ok=True)
    path = BUILD / f"{system.name}.mjcf.xml"
    path.write_bytes(ElementTree.tostring(mjcf(system)))
    turning = np.array(
        [system.angle_index(link.parent) if link.revolute else -2 for link in system.links],
        dtype=np.int32,
    )
    message = ctypes.create_string_buffer(500)
    place = _places(system)
    model = library().mujoco_new(
        str(path).encode(), turning.ctypes.data, place.ctypes.data, message, len(message)
    )
    if not model:
        raise UnavailableError(f"MuJoCo refuses {path.name}: {message.value.decode()}")
    if library().mujoco_size(model) != system.size:
        raise UnavailableError(f"MuJoCo gives {path.name} another number of degrees of freedom")
    return model


def mjcf(system: System) -> ElementTree.Element:
    """The system as MJCF; body frames are at the joints."""
    root = ElementTree.Element("mujoco")
    _add(root, "compiler", angle="radian", inertiafromgeom="false", autolimits="false")
    _add(root, "option", gravity=_text(0, 0, -GRAVITY))
    bodies = {GROUND: _add(root, "worldbody")}
    torsions = {t.link: t for t in system.torsions}
    for k, link in enumerate(system.links):
        offset = _centre(system, link.parent)
        position = [a + b for a, b in zip(offset, link.parent_to_joint, strict=True)]
        bodies[k] = body = _add(
            bodies[link.parent], "body", name=f"body{k}", pos=_text(position[0], 0, position[1])
        )
        kind = (
            {"type": "hinge", "axis": "0 1 0"}
            if link.revolute
            else {
                "type": "slide",
                "axis": _text(link.direction[0], 0, link.direction[1]),
            }
        )
        if k in torsions:
            t = torsions[k]
            kind |= {"stiffness": _text(t.stiffness), "damping": _text(t.damping)}
            kind["springref"] = _text(t.angle)
        _add(body, "joint", **kind)
        x, z = link.joint_to_child
        inertia = _text(link.inertia, link.inertia, link.inertia)
        _add(body, "inertial", pos=_text(x, 0, z), mass=_text(link.mass), diaginertia=inertia)
    tendons = _add(root, "tendon")
    for k, spring in enumerate(system.springs):
        ends = (spring.first, spring.first_point), (spring.second, spring.second_point)
        tendon = _add(
            tendons,
            "spatial",
            stiffness=_text(spring.stiffness),
            damping=_text(spring.damping),
            springlength=_text(spring.length),
        )
        for end, (on, point) in enumerate(ends):
            x, z = (a + b for a, b in zip(_centre(system, on), point, strict=True))
            name = f"site{k}_{end}"
            _add(bodies[on], "site", name=name, pos=_text(x, 0, z))
            _add(tendon, "site", site=name)
    return root


def _places(system: System) -> np.ndarray:
    """Degree of freedom of each link: MuJoCo numbers depth first."""
    children: dict[int, list[int]] = {}
    for k, link in enumerate(system.links):
        children.setdefault(link.parent, []).append(k)
    places = np.empty(system.size, dtype=np.int32)
    waiting = children[GROUND][::-1]
    for count in range(system.size):
        link = waiting.pop()
        places[link] = count
        waiting += children.get(link, [])[::-1]
    return places


def _centre(system: System, link: int) -> Vector:
    return (0.0, 0.0) if link == GROUND else system.links[link].joint_to_child


def _add(parent: ElementTree.Element, tag: str, **attributes: str) -> ElementTree.Element:
    return ElementTree.SubElement(parent, tag, attributes)


def _text(*values: float) -> str:
    return " ".join(repr(float(v)) for v in values)


class MujocoForward:
    name = "MuJoCo mj_forward"
    largest = 200
    largest_with_loads = 200

    def prepare(self, system: System) -> Prepared:
        loaded = library()
        evaluate, rates = (address(loaded, f"mujoco_{n}") for n in ("evaluate", "rates"))
        began = cpu_seconds()
        model = new(system)
        preparation = cpu_seconds() - began
        x = interleaved(system.q, system.u)
        loaded.mujoco_set(model, x.ctypes.data)

        def accelerations(q: Sequence[float], u: Sequence[float]) -> Floats:
            return call_rates(rates, model, q, u)

        return Prepared(accelerations, native_batch(evaluate, model, x), preparation)

    def kernel(self, system: System) -> int:
        """Address of `void f(t, x, fixed, rates)` for the same C integrator as ours."""
        library().mujoco_select(new(system))
        return address(library(), "mujoco_kernel")
