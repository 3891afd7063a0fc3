"""Damage of YAML and XML by their structure: the result is always a text that parsers can read."""

from __future__ import annotations

import copy
import json
import random
from typing import Any

from lxml import etree
from ruamel.yaml import YAML
from support.fuzz.texts import XML_WORDS

LARGEST = 300_000
"""Characters of a YAML text: longer ones take longer than a case may, by their honest length."""
NUMBERS = (
    0, -1, 1, 2, 1e300, -1e300, 1e-300, 5e-324, 1e155, -1e100, 1e16, 2**31, 2**53, 2**63, -(2**63),
    2**64, 10**30, 10**400, float("nan"), float("inf"), -float("inf"), 0.1, -0.0, 1e12, 1e9, True,
)  # fmt: skip
TEXTS = (
    "", " ", "t", "x + y", "1/0", "1e400 m", "5 m^999999999", "3 m", "1 furlong", "-5 deg", "a.b",
    "a.b -> c.d", "../../x", "/abs/x", "C:\\x", "con", "a/b", "\x1b[2J", "\u202ea", "\ud800", "\0",
    "x" * 300, "x" * 100_000, "\n", "a\nb", "*", "**", "a*", "{", "%s", "{0}", "$(x)", "`x`",
    "<b>", "&amp;", "\\input{x}", "sin(t)", "sin(sin(sin(t)))", "exp(exp(exp(t)))", "t**t**t",
    "9**9**9", "(" * 200 + "t" + ")" * 200, "+".join(["t"] * 900), "true", "null", "1", "1e3",
    "٣", "²", "ß", "/dev/zero", "/proc/self/environ", ".", "..", "jacobi", "auto", "name", "time",
    "1e-320", "0x10", "1_000", "nan", "inf", "-inf", "10 ms", "1e400",
)  # fmt: skip
OTHERS = (
    None, [], {}, [0], [0, 0], [1, 2, 3], [[0, 1], [1, 0]], {"a": 1}, {"name": "a"}, [None], [[]],
    {"": ""}, {1: 2}, [float("nan")] * 3, ["a", "a"], [{}], {"value": 1, "unit": "m"},
)  # fmt: skip


def damaged_yaml(content: bytes, rng: random.Random) -> bytes:
    """A YAML text with one to three pieces of its tree changed; unchanged if it has no tree."""
    try:
        data = YAML(typ="safe", pure=True).load(content.decode("utf-8"))
    except Exception:  # noqa: BLE001  of damage that came before
        return content
    if not isinstance(data, dict):
        return content
    whole = copy.deepcopy(data)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        _change(data, whole, rng)
    text = json.dumps(data, indent=1, default=str, ensure_ascii=rng.random() < 0.5)
    if len(text) > LARGEST:
        return content
    for old, new in (("-Infinity", "-.inf"), ("Infinity", ".inf"), ("NaN", ".nan")):
        text = text.replace(old, new)
    return text.encode("utf-8", "surrogatepass" if rng.random() < 0.1 else "replace")


def _change(data: Any, whole: Any, rng: random.Random) -> None:
    found = list(_places(data))
    if not found:
        return
    *parents, last = rng.choice(found)
    target = data
    for key in parents:
        target = target[key]
    match rng.randrange(10):
        case 0:
            del target[last]
        case 1 if isinstance(target, dict):
            others = [place[-1] for place in found if isinstance(place[-1], str)]
            target[rng.choice((*others, *TEXTS[:20], 1))] = target.pop(last)
        case 2 | 3:
            target[last] = copy.deepcopy(_at(whole, rng.choice(list(_places(whole)))))
        case 4 if isinstance(target, list):
            target.extend(copy.deepcopy([target[last]]) * rng.choice((1, 1, 10, 100)))
        case 4:
            for k in range(rng.choice((1, 1, 10, 100))):
                target[f"{last}{k}"] = copy.deepcopy(target[last])
        case 5:
            deep: Any = target[last]
            for _ in range(rng.choice((1, 1, 2, 50, 150))):  # pyrefly: ignore[non-convergent-recursion]
                deep = [deep] if rng.random() < 0.5 else {"a": deep}
            target[last] = deep
        case 6 | 7:
            target[last] = rng.choice(NUMBERS)
        case 8:
            target[last] = rng.choice(TEXTS)
        case _:
            target[last] = copy.deepcopy(rng.choice(OTHERS))


def _places(data: Any) -> list[tuple[Any, ...]]:
    """Keys that lead to each value of nested data."""
    found: list[tuple[Any, ...]] = []
    waiting: list[tuple[tuple[Any, ...], Any]] = [((), data)]
    while waiting:
        keys, value = waiting.pop()
        if keys:
            found.append(keys)
        if isinstance(value, dict):
            waiting += [((*keys, key), member) for key, member in value.items()]
        elif isinstance(value, list):
            waiting += [((*keys, k), member) for k, member in enumerate(value)]
    return found


def _at(data: Any, keys: tuple[Any, ...]) -> Any:
    for key in keys:
        data = data[key]
    return data


def damaged_xml(content: bytes, rng: random.Random) -> bytes:
    """An XML text with one to three pieces of its tree changed, or a DOCTYPE put in."""
    try:
        root = etree.fromstring(content)
    except (etree.XMLSyntaxError, ValueError):
        return content
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        _change_element(root, rng)
    text = etree.tostring(root, encoding="unicode")
    if rng.random() < 0.05:
        text = f'<!DOCTYPE a [<!ENTITY b "{"c" * 100}">]>{text}'
    encoding = rng.choice(("UTF-8",) * 12 + ("UTF-16", "UTF-32", "ISO-8859-1", "EUC-JP", "UTF-7"))
    head = f'<?xml version="1.0" encoding="{encoding}"?>\n'
    return (head + text).encode(encoding, "replace")


def _change_element(root: Any, rng: random.Random) -> None:
    elements = [e for e in root.iter() if isinstance(e.tag, str)]
    element, other = rng.choice(elements), rng.choice(elements)
    parent = element.getparent()
    match rng.randrange(12):
        case 0 if parent is not None:
            parent.remove(element)
        case 1 if parent is not None:
            for _ in range(rng.choice((1, 1, 3, 1000))):
                parent.append(copy.deepcopy(element))
        case 2 if element.attrib:
            del element.attrib[rng.choice(list(element.attrib))]
        case 3:
            for name, value in other.attrib.items():
                element.set(name, value)
        case 4:
            element.append(copy.deepcopy(other))
        case 5:
            element.tag = other.tag
        case 6:
            for _ in range(rng.choice((1, 10, 240, 400))):
                element = etree.SubElement(element, element.tag)
        case 7:
            element.text = rng.choice(XML_WORDS[:8])
        case _ if element.attrib:
            word = rng.choice(XML_WORDS)
            if rng.random() < 0.3:
                known = [v for e in elements for v in e.attrib.values()]
                word = rng.choice(known)
            element.set(rng.choice(list(element.attrib)), word)
