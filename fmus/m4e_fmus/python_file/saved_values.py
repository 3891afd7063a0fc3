"""Attributes of the user's object as JSON values and bytes, and back.

Travels in the FMU: it imports the standard library only, and NumPy where an attribute is of it.
"""

from __future__ import annotations

import random
from collections import deque

from .user_class import Value, VariableGroup  # side by side in the FMU

KIND = "m4e kind"


class CannotBeSavedError(Exception):
    """A value of a type that has no form as JSON."""


def encoded(value: Value, name: str) -> Value:
    """`value` as JSON values and bytes; CannotBeSavedError with the `name` of what cannot."""
    kind = type(value)
    if kind in (type(None), bool, int, float, str, bytes):
        return value
    if kind is list:
        return [encoded(each, name) for each in value]
    if kind is dict and all(isinstance(key, str) for key in value):
        return {key: encoded(each, f"{name}[{key!r}]") for key, each in value.items()}
    if kind is dict:
        keys = [encoded(key, f"a key of {name}") for key in value]
        values = [encoded(each, f"{name}[{key!r}]") for key, each in value.items()]
        return _tagged("dict", [keys, values])
    if kind is complex:
        return _tagged("complex", [value.real, value.imag])
    if kind is tuple:
        return _tagged("tuple", [encoded(each, name) for each in value])
    if kind is deque:
        return _tagged("deque", [encoded(each, name) for each in value], value.maxlen)
    if kind is random.Random:
        return _tagged("random", encoded(value.getstate(), name))
    return _of_numpy(value, name)


def _of_numpy(value: Value, name: str) -> Value:
    if type(value).__module__ == "numpy" and hasattr(value, "tolist"):
        kind = value.dtype.str
        if value.dtype.hasobject:
            return _tagged("array", encoded(value.tolist(), name), kind)
        if value.dtype.names is None:
            return _tagged("bytes of array", value.tobytes(), [kind, list(value.shape)])
    if hasattr(value, "bit_generator"):
        state = value.bit_generator.state
        return _tagged("generator", encoded(state, name), state["bit_generator"])
    if isinstance(value, VariableGroup):
        raise CannotBeSavedError(
            f"{name} is the object of values, which has others in the next step: keep the numbers "
            "that you need, as self.angle = v.angle"
        )
    raise CannotBeSavedError(
        f"{name} is of type {type(value).__name__}, which cannot be saved: make it of numbers, "
        "texts, lists, dicts and NumPy arrays, or give the class methods save() and restore(saved)"
    )


def decoded(value: Value) -> Value:
    """The value that `encoded` was given."""
    if isinstance(value, list):
        return [decoded(each) for each in value]
    if not isinstance(value, dict):
        return value
    if KIND not in value:
        return {key: decoded(each) for key, each in value.items()}
    kind, content, more = value[KIND], decoded(value["content"]), value["more"]
    match kind:
        case "tuple":
            return tuple(content)
        case "deque":
            return deque(content, more)
        case "dict":
            return dict(zip(*content, strict=True))
        case "complex":
            return complex(*content)
        case "random":
            generator = random.Random()
            generator.setstate(content)
            return generator
        case _:
            import numpy as np

            if kind == "bytes of array":
                return np.ndarray(more[1], more[0], buffer=content).copy()[()]
            if kind == "array":
                return np.array(content, dtype=more)[()]
            generator = np.random.Generator(getattr(np.random, more)())
            generator.bit_generator.state = content
            return generator


def _tagged(kind: str, content: Value, more: Value = None) -> dict[str, Value]:
    return {KIND: kind, "content": content, "more": more}
