"""Damage of texts: words exchanged for odd ones, lines moved, bytes changed."""

from __future__ import annotations

import random
import re
from contextlib import suppress

WORDS = (
    "[]", "{}", "null", "~", "true", "''", "1e300", "-1e-300", "1e-300", "1e200", "-1e155", "1e999",
    ".nan", ".inf", "-1", "0", "9" * 5000, "0x7fffffffffffffffffff", "1_000", "2001-01-01",
    "2001-13-45", "!!binary x", "!!set {a, b}", "!!omap [a: 1]", "!!timestamp x", "!!int x",
    "!!float x", "!!python/name:os.system x", "*a", "&a [*a]", "&a {a: *a}", "../../x", "/abs/x",
    "con", "nul.txt", "a/b", '"a\\u202eb\\u001b[2J"', "'@sections@'", "x" * 3000, "sign(1e308*10)",
    "1/0", "0**-1", "(-1)**0.5", "log(0)", "1e308*1e308", "exp(1e9)", "2**1e5", "1e300**2", "t",
    "sin(", "__import__('os').abort()", "(" * 500, "1" + "+1" * 3000, "- a", "a: b", "? a",
    "<<: *x", "/dev/null", "/proc/self/environ", "/", ".", "\u00b2", "\ud7ff", "1e100", "1e-100",
    "5 m^999999999", "1e400 m", "3 m^-99999", "m^999999999", "9**9**9**9", "2**(2**(2**99))",
    "[" * 300, "{a: " * 300, "- " * 300, "!" * 300, "!!float 1:1:1", "1:1:1:1", "\"\\ud800\"",
    "0b1", "1e99999999999999999999", "-9223372036854775809", "1" + "0" * 400, "name", "time",
)  # fmt: skip
BYTES = (
    b"\0",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\r",
    b"\t",
    b"\x1b[2J",
    b"\xc2\x85",
    b"%",
    b"<",
    b"&",
)
XML_WORDS = (
    "", "x", "-1", "1e400", "NaN", "INF", "4294967296", "99999999999999999999", "../../x", "/abs/x",
    "true", "1 2 3", "3000", "con", "x" * 3000, "&#x202e;&#10;", "@sections@", "2.0", "3.0", "1.0",
    "0", "Real", "input", "fixed", "0.5.5", "9223372036854775808", "18446744073709551616", "1_0",
    "9" * 5000, "-0", "m^999999999", "1e-400", "&lt;b&gt;", "\u0663",
)  # fmt: skip


def damaged_text(content: bytes, words: tuple[str, ...], rng: random.Random) -> bytes:
    """A text with one word, value or line changed; `words` are odd ones."""
    text = content.decode("utf-8", "replace")
    pieces = _pieces(text, '"' if text.lstrip().startswith("<") else "")
    lines = text.split("\n")
    k = rng.randrange(len(lines))
    match rng.randrange(8):
        case 0:
            del lines[k]
        case 1:
            lines.insert(k, lines[rng.randrange(len(lines))])
        case 2:
            lines[k] = " " * rng.randrange(6) + lines[k].strip()
        case _ if pieces:
            begin, end = rng.choice(pieces)
            word = rng.choice(words)
            if rng.random() < 0.2:
                other = rng.choice(pieces)
                word = text[other[0] : other[1]]
            return (text[:begin] + word + text[end:]).encode("utf-8", "replace")
    return "\n".join(lines).encode("utf-8", "replace")


def damaged_bytes(content: bytes, rng: random.Random) -> bytes:
    """The content cut off, with a byte changed or some put in, or in another encoding."""
    place = rng.randrange(len(content) + 1)
    match rng.randrange(5):
        case 0:
            return content[:place]
        case 1:
            return content[:place] + rng.choice(BYTES) + content[place:]
        case 2:
            return content[:place] + bytes([rng.randrange(256)]) + content[place + 1 :]
        case 3:
            return content[:place] + content[place // 2 :]
        case _:
            with suppress(UnicodeDecodeError):
                return content.decode().encode(rng.choice(("utf-16", "utf-32", "utf-7")))
            return content


def _pieces(text: str, quote: str) -> list[tuple[int, int]]:
    """Where words begin and end: between quotes, or what a line has between its separators."""
    pattern = f"(?<=={quote})[^{quote}]*" if quote else r"[^\s\[\]{},:#\"'<>]+"
    return [m.span() for m in re.finditer(pattern, text)]
