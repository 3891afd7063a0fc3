"""Checkpoints of all that a run can have: types of values, events, loops, workers, scenarios."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from support.interrupted import check_resumed
from support.small_systems import Fmus

from m4e_fmi.cosim import Action, Component, FmuFile, Simulation, System

KINDS = ("int", "bool", "enum", "text")
SAVES = "+state+bytes"
SPRING = ("body.m <-> spring.end",)


def part(c_fmu: Fmus, name: str, fmu: str, **values: float | str) -> Component:
    return Component(name, FmuFile(c_fmu(fmu + SAVES)), values)


def made(*parts: Component, links: tuple[str, ...], algorithm: str = "jacobi") -> System:
    return System("s", parts, links, Simulation(4, 0.1, algorithm))


def types(c_fmu: Fmus) -> System:
    """Values of all types, arrays among them, some a step late."""
    pairs = (("a", "b"), ("b", "c"))
    links = tuple(f"{one}.y_{k} -> {two}.u_{k}" for one, two in pairs for k in KINDS)
    late = ("b.y_real -> a.u_real, delayed", "b.y_words -> c.u_words")
    parts = (
        part(c_fmu, "c", "3:kinds"),
        part(c_fmu, "b", "3:kinds+through"),
        part(c_fmu, "a", "kinds", period=0.3),
    )
    return made(*parts, links=(*links, *late))


def events(c_fmu: Fmus) -> System:
    """A ball that bounces, and tells of it."""
    parts = (part(c_fmu, "ball", "3:ball+events", restitution=0.9), part(c_fmu, "body", "mass"))
    return made(*parts, links=("body.body.m.x -> ball.push",), algorithm="corrector")


def loop(c_fmu: Fmus) -> System:
    """An algebraic loop beside an oscillator."""
    parts = (
        part(c_fmu, "a", "stage", gain=0.5),
        part(c_fmu, "b", "stage", gain=-0.5),
        part(c_fmu, "body", "mass", **{"body.m.x": 1.0}),
        part(c_fmu, "spring", "spring"),
    )
    return made(*parts, links=("a.y -> b.u", "b.y -> a.u", *SPRING), algorithm="gauss_seidel")


def rates(c_fmu: Fmus) -> System:
    """A sampled component, and one that says something at first."""
    body = part(c_fmu, "body", "mass+loud", **{"body.m.x": 1.0})
    spring = replace(part(c_fmu, "spring", "spring+discrete"), step_size="0.2 s")
    return made(body, spring, links=SPRING, algorithm="corrector")


def oscillator(c_fmu: Fmus) -> System:
    body = part(c_fmu, "body", "mass", **{"body.m.x": 1.0})
    links = ("body.body.m.x -> spring.end.x", "body.body.m.vx -> spring.end.vx")
    spring = part(c_fmu, "spring", "spring", damping=0.3)
    return made(body, spring, links=(*links, "spring.end.force_x -> body.body.m.force_x"))


def workers(c_fmu: Fmus) -> System:
    """FMUs in processes of their own."""
    whole = oscillator(c_fmu)
    return replace(whole, components=tuple(replace(c, process="own") for c in whole.components))


def scenario(c_fmu: Fmus) -> System:
    """Actions that remember: what is frozen, delayed, lost, drawn, and set on a condition."""
    signal = "spring.end.vx"
    actions: Mapping[str, Action] = {
        "stuck": Action(freeze=(signal,), at=0.5, duration=1.0),
        "drift": Action(offset={signal: 0.01}, at=0.2, duration=1.0),
        "stiff": Action(ramp={"spring.damping": 0.5}, within=1.0, when="body.body.m.x < 0.5 m"),
    }
    return replace(oscillator(c_fmu), scenario=actions)


@pytest.mark.parametrize("make", [types, events, loop, rates, workers, scenario])
def test_the_bits_are_those_of_the_undisturbed_run(
    c_fmu: Fmus, tmp_path: Path, make: Callable[[Fmus], System]
) -> None:
    told = check_resumed(make(c_fmu), tmp_path, 0.3, [1.25, 2.75])
    assert told == [f"the run goes on at t = {time:g} s" for time in (1.2, 2.7)]
