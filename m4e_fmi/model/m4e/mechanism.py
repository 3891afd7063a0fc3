"""Bodies, joints, start values, gravity and symbols from the paper's lists."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property

from m4e_fmi.files.document import Location
from m4e_fmi.joints import FLOATING, PRISMATIC, REVOLUTE, JointType
from m4e_fmi.model.elements import GROUND, Body, Joint, Parameter
from m4e_fmi.model.groups import STANDARD_GRAVITY
from m4e_fmi.model.m4e.values import (
    NAN,
    Data,
    Lists,
    added,
    first_of,
    is_nan,
    is_number,
    is_row,
    is_whole,
    plus,
)

ROWS = ("types", "parent_cg_to_joint", "joint_to_child_cg", "prismatic_direction")
SYMBOLS = (("BodyDataSym", "BodyDataNum"), ("ForcesPointsSym", "ForcesPointsNum"))
TYPES: dict[str, JointType] = {"R": REVOLUTE, "P": PRISMATIC, "F": FLOATING}


class Mechanism(Lists):
    """Bodies and joints of the lists; `symbols` are the parameters, `children` bodies by number.

    `children` maps a body's number to the row of its joint, `rows` a row to (parent, child).
    """

    def __init__(
        self, lists: Mapping[str, Data], parameters: Mapping[str, Parameter | float]
    ) -> None:
        super().__init__(lists)
        self.symbols = dict(self._symbols(parameters))
        self.rows = self._joint_rows()
        self.children = {child: row for row, (_, child) in self.rows.items()}

    def _symbols(self, extra: Mapping[str, Parameter | float]) -> Iterator[tuple[str, Parameter]]:
        """Symbols with values; the time is none of them."""
        for names_key, values_key in SYMBOLS:
            names, values = (
                self.list_of(key, "give a list, empty if there are none")
                if key in self.lists
                else []
                for key in (names_key, values_key)
            )
            if len(names) != len(values):
                message = f"{len(names)} symbols in {names_key}, {len(values)} values"
                self.say((values_key,), message, "give one value for each symbol, in their order")
            for k, (name, value) in enumerate(zip(names, values, strict=False)):
                at = ("parameters", str(name))
                self.places |= {at: (names_key, k), (*at, "value"): (values_key, k)}
                if str(name) != "t":
                    yield str(name), Parameter(value, "1", f"Symbol {name} of the lists")
        for name, value in extra.items():
            self.places["parameters", name] = ("parameters", name)
            if not isinstance(value, Parameter):
                value = Parameter(value, "1", f"Symbol {name}")
            yield name, value

    def _joint_rows(self) -> dict[int, tuple[int, int]]:
        """(parent, child) of every row of `joints` that is right; checks numbers and lengths."""
        joints = self.list_of("joints", "give one [parent, child] per joint; the ground is 0")
        rows: dict[int, tuple[int, int]] = {}
        for k, row in enumerate(joints):
            if not (is_row(row, 2) and all(map(is_whole, row))):
                self.say(
                    ("joints", k), f"expected [parent, child], got {row!r}", "two body numbers"
                )
                continue
            parent, child = row
            if parent < 0 or child < 1:
                message = f"body numbers begin at 1 (the ground is 0), got {row!r}"
                self.say(("joints", k), message, "number the bodies 1, 2, 3, …")
                continue
            rows[k] = (parent, child)
        for key in ROWS:
            if key in self.lists or key != "prismatic_direction":
                entries = self.list_of(key, "give one entry per joint")
                if len(entries) != len(joints) and key in self.lists:
                    message = f"{len(entries)} rows, but joints has {len(joints)}"
                    self.say((key,), message, "give one row per joint, in the order of joints")
        self._check_numbers(rows)
        return rows

    def _check_numbers(self, rows: dict[int, tuple[int, int]]) -> None:
        children = [child for _, child in rows.values()]
        first: dict[int, int] = {}
        for k, (parent, child) in rows.items():
            if first.setdefault(child, k) != k:
                message = f"body {child} is the child of joints[{first[child]}] already"
                remedy = (
                    "closed loops: cut one joint and put stiff springs and dampers in its place"
                )
                self.say(("joints", k, 1), message, remedy)
            if parent and parent not in children:
                message = f"body {parent} is a parent, but no joint has it as its child"
                self.say(("joints", k, 0), message, f"add a joint [0, {parent}]")
        missing = sorted({*range(1, len(first) + 1)} - {*first})
        if missing:
            message = f"bodies are numbered without gaps; missing: {', '.join(map(str, missing))}"
            remedy = "renumber the bodies, or add joints for the missing ones"
            self.say(("joints",), message, remedy)

    @cached_property
    def origin(self) -> list[Data]:
        """`Reference_frame_Origin` [m], (0, 0) if none is given."""
        origin = self.lists.get("Reference_frame_Origin", [0.0, 0.0])
        if not is_row(origin, 2):
            message = f"expected [x, z], got {origin!r}"
            self.say(("Reference_frame_Origin",), message)
            return [0.0, 0.0]
        return origin

    def gravity(self) -> Data:
        """Gravity, the parameter `g` where it is a number; it acts on all bodies alike."""
        if "gVec" in self.lists:
            scales = map(first_of, self._per_body("gVec", len(self.children)))
            if not all(is_number(scale) and scale == 1 for scale in scales):
                message = "gravity acts on all bodies alike: 1 is all that gVec may hold"
                remedy = "change g, or give the difference as a force: Force['CG']"
                self.say(("gVec",), message, remedy)
        self.places["gravity",] = ("g",)
        g = self.lists.get("g", STANDARD_GRAVITY)
        return self._as_parameter("g", g, "m/s2", ("g",), "Gravity")

    def _per_body(self, key: str, count: int) -> list[Data]:
        values = self.list_of(key, "give one number per body")
        if key in self.lists and len(values) != count:
            message = f"{len(values)} entries for {count} bodies"
            self.say((key,), message, "give one entry per body, in the order of their numbers")
        return values

    def _as_parameter(self, name: str, value: Data, unit: str, at: Location, text: str) -> Data:
        """`name`, a new parameter, for a number; an expression as it is."""
        if not is_number(value) or name in self.symbols:
            return value
        self.symbols[name] = Parameter(float(value), unit, text)
        self.places["parameters", name] = at
        return name

    def bodies(self) -> dict[str, Body]:
        """The bodies by name, in the order of their numbers."""
        count = len(self.children)
        masses, inertias = self._per_body("m0", count), self._per_body("J0", count)
        bodies = {}
        for child, row in sorted(self.children.items()):
            at = ("bodies", f"body_{child}")
            k = child - 1
            self.places |= {
                at: ("joints", row, 1), (*at, "mass"): ("m0", k), (*at, "inertia"): ("J0", k)
            }  # fmt: skip
            if k < len(masses) and k < len(inertias):
                mass, inertia = first_of(masses[k]), first_of(inertias[k])
                text = f"of body {child}"
                bodies[at[1]] = Body(
                    self._as_parameter(f"m{child}", mass, "kg", ("m0", k), f"Mass {text}"),
                    self._as_parameter(
                        f"J{child}", inertia, "kg.m2", ("J0", k), f"Inertia {text} about its CG"
                    ),
                    f"Body {child}",
                )
        return bodies

    def joints(self) -> dict[str, Joint]:
        """The joints by name, in the order of their children's numbers."""
        initial = self._initial()
        joints = {}
        for child, row in sorted(self.children.items()):
            parent = self.rows[row][0]
            letter, types = self._type(row), self.lists.get("types")
            if letter is None:
                if isinstance(types, list) and row < len(types):
                    message = f"unknown type {types[row]!r}"
                    self.say(("types", row), message, "known: 'R', 'P', 'F'")
                continue
            at = ("joints", f"joint_{child}")
            self.places |= {
                at: ("joints", row),
                (*at, "child"): ("joints", row, 1),
                (*at, "parent"): ("joints", row, 0),
                (*at, "parent_to_joint"): ("parent_cg_to_joint", row),
                (*at, "joint_to_child"): ("joint_to_child_cg", row),
                (*at, "direction"): ("prismatic_direction", row),
            }
            values = initial.get(child, {})
            if TYPES[letter].is_free:
                vectors = self._floating(row, parent, values)
            else:
                vectors = self._vectors(row, parent, letter)
            if vectors is not None:
                holder = f"body_{parent}" if parent else GROUND
                joints[at[1]] = Joint(
                    TYPES[letter].name, f"body_{child}", holder, **vectors, initial=values
                )
        return joints

    def _vectors(self, row: int, parent: int, letter: str) -> dict[str, Data] | None:
        """Geometry of a revolute or prismatic joint."""
        result: dict[str, Data] = {}
        fields = [
            ("parent_to_joint", "parent_cg_to_joint"),
            ("joint_to_child", "joint_to_child_cg"),
        ]
        direction = self._vector("prismatic_direction", row) or [NAN, NAN]
        if TYPES[letter].has_direction:
            fields.append(("direction", "prismatic_direction"))
        elif any(entry is not NAN for entry in direction):
            message = f"a joint of type {letter!r} has no direction"
            self.say(("prismatic_direction", row), message, "write [nan, nan]")
            return None
        for field, key in fields:
            vector = self._vector(key, row)
            if vector is None and key not in self.lists:
                message = f"a joint of type {letter!r} needs a direction, and there is no {key}"
                self.say(
                    ("types", row), message, f"add {key}: [x, z] per joint, [nan, nan] if none"
                )
            if vector is None:
                return None
            if any(entry is NAN for entry in vector):
                message = f"a joint of type {letter!r} needs both entries, got NaN"
                self.say((key, row), message, "give the vector [x, z]")
                return None
            result[field] = tuple(vector)
        if not parent:
            result["parent_to_joint"] = added(self.origin, result["parent_to_joint"])
        return result

    def _floating(self, row: int, parent: int, values: dict[str, Data]) -> dict[str, Data] | None:
        """No geometry, but the start position goes into `values`."""
        if parent:
            message = f"a floating joint is always to the ground, got the parent {parent}"
            self.say(("joints", row, 0), message, f"write [0, {self.rows[row][1]}]")
            return None
        for key in ("joint_to_child_cg", "prismatic_direction"):
            for entry in self._vector(key, row) or []:
                if entry is not NAN and entry != 0:
                    message = f"a floating joint has no {key}"
                    self.say((key, row), message, "write [nan, nan]")
                    return None
        start = self._vector("parent_cg_to_joint", row)
        if start is None:
            return None
        for axis, place, shift in zip("xz", start, self.origin, strict=True):
            given = values.get(axis, 0.0)
            if place is NAN:
                place = given
            elif is_number(given) and given not in (0, place):
                message = (
                    f"{axis} starts at {given:g} here, at {place} in parent_cg_to_joint[{row}]"
                )
                remedy = "say it in one of the two: 0 here, or nan there"
                self.say(self.places["joints", f"joint_{self.rows[row][1]}", "initial", axis],
                         message, remedy)  # fmt: skip
            values[axis] = plus(shift, place)
        return {}

    def _vector(self, key: str, row: int) -> list[Data] | None:
        """Row `row` of a list of vectors, NAN for entries that are NaN; None if it is no vector."""
        rows = self.lists.get(key)
        if not isinstance(rows, list) or row >= len(rows):
            return None
        if not is_row(rows[row], 2):
            self.say((key, row), f"expected [x, z], got {rows[row]!r}")
            return None
        return [NAN if is_nan(entry) else entry for entry in rows[row]]

    def _initial(self) -> dict[int, dict[str, Data]]:
        """Start values of every joint, by the number of its child."""
        slots = []  # (child, letter of the coordinate, key of q, key of u)
        for child, row in sorted(self.children.items()):
            coordinates = TYPES[self._type(row) or "R"].coordinates
            slots += [(child, c.letter, c.position, c.velocity) for c in coordinates]
        ic = self.lists.get("ic")
        values = [first_of(entry) for entry in ic] if isinstance(ic, list) else []
        count = len(slots)
        if "ic" in self.lists and len(values) != 2 * count:
            q = [f"{name}_{child}" for child, name, _, _ in slots]
            u = [f"{name}D_{child}" for child, name, _, _ in slots]
            message = f"{len(values)} entries, expected {2 * count}"
            self.say(("ic",), message, f"in this order: {', '.join([*q, *u])}")
            return {}
        initial: dict[int, dict[str, Data]] = {}
        for k, (child, _, position, velocity) in enumerate(slots):
            for key, index in ((position, k), (velocity, k + count)):
                self.places["joints", f"joint_{child}", "initial", key] = ("ic", index)
                if values:
                    initial.setdefault(child, {})[key] = values[index]
        return initial

    def _type(self, row: int) -> str | None:
        """The letter of a joint's type; None for any other."""
        types = self.lists.get("types")
        letter = types[row] if isinstance(types, list) and row < len(types) else None
        return letter if isinstance(letter, str) and letter in TYPES else None
