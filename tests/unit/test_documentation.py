"""The documentation is built without a warning, and its pages show what comes out."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from doc_tools.api_text import escaped
from doc_tools.run_page import PageError, run_page
from doc_tools.script_page import script_text, write_script_page
from PIL import Image, ImageSequence

from m4e_fmi.cli import main
from m4e_fmi.model import load_model
from m4e_fmi.report import draw_model
from m4e_fmi.study import load_study

DOCS = Path(__file__).parents[2] / "docs"
SOURCES = ("m4e_fmi", "adapters", "fmus")


BUILD = """
import sys
from sphinx.application import Sphinx

docs, html = sys.argv[1:]
plain = {"html_theme": "basic", "html_theme_options": {}, "slow_scripts": False}
app = Sphinx(docs, docs, html, html + ".doctrees", "html", plain, None, sys.stderr, True, True)
app.builder.search = False  # nor is its index asked here
app.build()
sys.exit(app.statuscode)
"""


def check_picture(drawn: Path, config: pytest.Config) -> None:
    """The picture of this name in docs/, which readers of the Markdown see, is what is `drawn`."""
    kept = DOCS / drawn.name
    if config.getoption("--update"):
        shutil.copy(drawn, kept)
    new, old = (np.asarray(Image.open(path).convert("RGB"), float) for path in (drawn, kept))
    # of 255: room for another machine's rounding of edges; two names that moved made 3.5
    same = new.shape == old.shape and np.sqrt(np.mean((new - old) ** 2)) < 1
    assert same, f"{kept} is stale: pytest --update tests/unit/test_documentation.py"


def test_the_drawing_in_the_pages_is_what_is_drawn(
    tmp_path: Path, pytestconfig: pytest.Config
) -> None:
    model = load_model(DOCS.parent / "examples/paper_cases/spiderfloat.model.yaml")
    check_picture(draw_model(model, tmp_path / "spiderfloat.png"), pytestconfig)


def test_it_is_built_without_a_warning(tmp_path: Path, pytestconfig: pytest.Config) -> None:
    """All pages are linked, all links lead somewhere; pages and examples that run do."""
    command = [sys.executable, "-c", BUILD, DOCS, tmp_path / "html"]
    built = subprocess.run(command, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    html = tmp_path / "html"
    assert 'src="double_pendulum.html"' in (html / "tutorial.html").read_text(encoding="utf-8")
    assert (html / "double_pendulum.html").is_file()
    example = (html / "generated/examples/spiderfloat_lists.html").read_text(encoding="utf-8")
    assert "right slider at t = 10 s" in example
    assert 'src="../../spiderfloat.html"' in example
    assert (html / "spiderfloat.html").is_file()
    for name in ("double_pendulum_model.png", "tip.png"):
        check_picture(DOCS / "generated/pages/tutorial/build" / name, pytestconfig)


def test_the_tutorial_leads_to_a_power_matrix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What it says to change is in the example; its study has twelve runs, and its float a mass."""
    page = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    shape, mass, study = (
        text
        for text in re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
        if text.startswith((" ", "# study.yaml"))
    )
    example, place = DOCS.parent / "examples" / "moored_buoy", tmp_path / "my_buoy"
    shutil.copytree(example, place, ignore=shutil.ignore_patterns("build"))
    monkeypatch.chdir(place)
    text = Path("system.yaml").read_text("utf-8")
    assert "        shape: {cylinder: {radius: 4, draft: 3}}\n" in text
    text = re.sub(r"        shape: .*\n", shape, text)
    text = text.replace("connections:\n", f"connections:\n{mass}")
    Path("system.yaml").write_text(text, "utf-8")
    Path("study.yaml").write_text(study, "utf-8")
    assert load_study("study.yaml").grid.count == 12
    assert main(["info", "system.yaml"]) == 0
    assert "neutral_mass - 11368.5 -> buoy.m" in capsys.readouterr().out


def test_the_readme_runs(tmp_path: Path) -> None:
    """Its commands do what they should; it is short, and its picture small and endless."""
    readme = DOCS.parent / "README.md"
    run_page(readme, tmp_path / "work")
    assert (tmp_path / "work/build/double_pendulum.fmu").is_file()
    assert len(readme.read_text(encoding="utf-8").splitlines()) <= 120
    picture = DOCS / "moored_buoy.gif"
    assert picture.stat().st_size <= 1.5e6
    with Image.open(picture) as moving:
        seconds = sum(p.info["duration"] for p in ImageSequence.Iterator(moving)) / 1000
        assert moving.info["loop"] == 0
    assert 6 <= seconds <= 10


def test_the_readme_has_the_speeds_that_were_measured() -> None:
    """Each time and ratio of its table of speed is in the benchmark's page, for the demo none."""
    table = (DOCS.parent / "README.md").read_text(encoding="utf-8").split("## Speed")[1]
    rows = re.findall(r"^\|(?!-).*\|$", table, re.MULTILINE)[1:-1]
    numbers = [n for row in rows for n in re.findall(r"\d+\.\d+|\d+(?= µs)", row)]
    page = (DOCS / "benchmark.md").read_text(encoding="utf-8")
    assert len(numbers) == 11
    assert [
        n for n in numbers if not re.search(rf"(?<![\d.]){re.escape(n)}(?![\d.]\d)", page)
    ] == []


def test_the_code_has_all_names_of_the_glossary() -> None:
    rows = re.findall(r"^\|.*\|([^|]*)\|$", (DOCS / "glossary.md").read_text("utf-8"), re.MULTILINE)
    names = {name for cell in rows for name in re.findall(r"`(\w+)`", cell)}
    assert len(names) > 60
    files = [file for folder in SOURCES for file in (DOCS.parent / folder).rglob("*.py")]
    known = {name for file in files for name in (file.stem, file.parent.name)}
    known.update(word for file in files for word in re.findall(r"\w+", file.read_text("utf-8")))
    assert names - known == set()


MODEL = """\
```yaml
# link.model.yaml
name: link
bodies: {link: {mass: 1, inertia: 1}}
joints: {hinge: {type: revolute, child: link}}
```
"""


def run(page: str, folder: Path) -> None:
    path = folder / "page.md"
    path.write_text(page, encoding="utf-8")
    run_page(path, folder / "work")


def test_a_page_that_is_right(tmp_path: Path) -> None:
    command = "```console\n$ m4e-fmi equations link.model.yaml\nlink:\n...\n```\n"
    code = "```python\nx = 1\n```\n\n```python\nprint(x + 1)\n```\n\n```text\n2\n```\n"
    reading = "```sh\nmake coffee\n```\n\n```yaml\nany: thing\n```\n"
    digits = "```python\nprint('-4.18035 of 0.220649')\n```\n\n```text\n-4.18034 of 0.22065\n```\n"
    folder = "```sh\ncp -r examples/arm my\ncd my\nm4e-fmi run system.yaml  # long\n```\n"
    text = "```none\nlines.txt: a file\n```\n"
    run(MODEL + command + code + reading + digits + folder + text, tmp_path)
    assert (tmp_path / "work" / "link.model.yaml").is_file()
    assert (tmp_path / "work" / "my" / "lines.txt").is_file()


@pytest.mark.parametrize(
    ("page", "message"),
    [
        ("```python\nprint(1)\n```\n\n```text\n2\n```\n", "page.md:2: the page says\n2"),
        ("```python\nprint(4.18036)\n```\n\n```text\n4.18034\n```\n", "out is\n4.18036"),
        ("```python\nprint(4.2)\n```\n\n```text\n-4.2\n```\n", "out is\n4.2"),
        ("```python\n1 / 0\n```\n", "page.md:2: ZeroDivisionError"),
        ("```console\n$ m4e-fmi equations none.yaml\nlink:\n```\n", "but what comes out is\nerror"),
        ("```console\n$ m4e-fmi fly\n```\n", "invalid choice: 'fly'"),
        ("```console\n$ rm -rf .\n```\n", "commands are of m4e-fmi, got 'rm'"),
        ("```console\nm4e-fmi doctor\n```\n", "starts with a command"),
        ("```sh\nm4e-fmi equations none.yaml\n```\n", "SystemExit"),
    ],
)
def test_pages_that_are_wrong(page: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(PageError) as caught:
        run(page, tmp_path)
    assert message in str(caught.value)


SCRIPT = """\
# %% [markdown]
# # A title
# Text.

# %%
def main():
    print("found", 42)

# %%
if __name__ == "__main__":
    main()
"""


def test_a_script_becomes_a_page(tmp_path: Path) -> None:
    page = '# A title\nText.\n\n```python\ndef main():\n    print("found", 42)\n```\n'
    assert script_text(SCRIPT) == page
    script = tmp_path / "example.py"
    script.write_text(SCRIPT, encoding="utf-8")
    write_script_page(script, tmp_path / "pages")
    written = (tmp_path / "pages" / "example.md").read_text(encoding="utf-8")
    assert written.startswith("# A title\n")
    assert "```text\nfound 42\n```" in written


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("the drag c |v| v of `c_d`", r"the drag c \|v\| v of `c_d`"),
        ("each tuple of `Variable`s, g_c", r"each tuple of `Variable`\ s, g\_c"),
        ("    >>> x = 2 * y", "    >>> x = 2 * y"),
    ],
)
def test_docstrings_are_plain_text(line: str, expected: str) -> None:
    assert escaped(line) == expected
