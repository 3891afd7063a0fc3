"""Results of a validation: findings, gathered by group of checks."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from m4e_fmi.shown import first_of, listing, short

Severity = Literal["error", "warning", "note"]
SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")
SHOWN = 5
"""Of many things wrong in one way, how many a finding names."""


@short
@dataclass(frozen=True)
class Finding:
    """One thing found by the check `id` (``group.name``).

    `message` says what was measured; `basis` the clause of the standard it rests on, or the
    remedy; `words` what the FMU itself said meanwhile. An error breaks the standard or gives wrong
    results, a warning is what importers stumble over, a note is what to know.
    """

    id: str
    severity: Severity
    message: str
    basis: str = ""
    words: tuple[str, ...] = ()

    @classmethod
    def from_dict(cls, told: dict[str, Any]) -> Finding:
        """A finding from what `dataclasses.asdict` made, and JSON carried."""
        told = {**told, "words": tuple(told["words"])}
        return cls(**told)

    def of(self, version: str) -> Finding:
        """The same of an FMU of this version: FMI 3.0 has 2.0's rules, by other names."""
        if not version.startswith("3"):
            return self
        basis = self.basis.replace("FMI 2.0.4", "FMI 3.0, as FMI 2.0.4")
        message, basis = (text.replace("fmi2", "fmi3") for text in (self.message, basis))
        return replace(self, message=message, basis=basis)


def failure(error: BaseException) -> str:
    """How a check of ours broke down, which says nothing about the FMU: kind, text, our line."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if "m4e_fmi" in Path(f.filename).parts] or frames
    place = f" ({Path(own[-1].filename).name}:{own[-1].lineno})" if own else ""
    return f"{type(error).__name__}: {error}{place}"


@short
@dataclass(frozen=True)
class Group:
    """A group of checks: its findings, or why it was not run; `seconds` it took.

    `failed` is the error of ours that ended it early, "" if there was none.
    """

    name: str
    findings: tuple[Finding, ...] = ()
    skipped: str = ""
    seconds: float = 0.0
    failed: str = ""

    @classmethod
    def from_dict(cls, told: dict[str, Any]) -> Group:
        """A group from what `dataclasses.asdict` made, and JSON carried."""
        findings = tuple(Finding.from_dict(finding) for finding in told["findings"])
        told = {**told, "findings": findings}
        return cls(**told)

    def count(self, severity: Severity) -> int:
        """Number of findings of one severity."""
        return sum(finding.severity == severity for finding in self.findings)

    @property
    def passed(self) -> bool:
        """True if it was run and found neither error nor warning."""
        troubles = self.count("error") or self.count("warning")
        return not (self.skipped or self.failed or troubles)


@dataclass(frozen=True)
class Report:
    """The outcome of a validation; `ok` if there is no error.

    `complete` if no check of ours failed to run: what it would have found is not known.
    """

    path: Path
    groups: tuple[Group, ...] = field(default=())

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All findings, errors first."""
        found = [finding for group in self.groups for finding in group.findings]
        return tuple(sorted(found, key=lambda f: SEVERITIES.index(f.severity)))

    def of_severity(self, *severities: Severity) -> tuple[Finding, ...]:
        """Findings of these severities."""
        return tuple(f for f in self.findings if f.severity in severities)

    @property
    def ok(self) -> bool:
        """True if there are no errors."""
        return not self.of_severity("error")

    @property
    def complete(self) -> bool:
        """True if every check could be run."""
        return not any(group.failed for group in self.groups)

    def as_dict(self) -> dict[str, object]:
        """The report as JSON values."""
        groups = [asdict(group) for group in self.groups]
        told = {"ok": self.ok, "complete": self.complete, "groups": groups}
        return {"fmu": str(self.path), **told}

    def __repr__(self) -> str:
        counts = (f"{len(self.of_severity(s))} {s}s" for s in SEVERITIES)
        return listing(
            f"Report on {self.path.name!r}: {', '.join(counts)}",
            groups=self.groups,
            findings=[f"{f.severity}: {f.message}" for f in self.findings],
        )


def about(
    names: Iterable[str], id_: str, severity: Severity, message: str, basis: str = ""
) -> Iterator[Finding]:
    """A finding on `names`, if there are any: the first few stand behind the message.

    The message has their number at {count}.
    """
    names = list(dict.fromkeys(names))
    if names:
        text = message.format(count=len(names))
        yield Finding(id_, severity, f"{text}: {first_of(names, SHOWN)}", basis)
