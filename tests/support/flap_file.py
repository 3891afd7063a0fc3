"""A model file with every kind of load and table, and the table beside it (wave.csv)."""

from pathlib import Path

from ruamel.yaml import YAML

CORPUS = Path(__file__).parents[1] / "corpus" / "loads.yaml"
FILES = YAML(typ="safe").load(CORPUS.read_text("utf-8"))["files"]
TEXT, WAVE = FILES["flap.model.yaml"], FILES["wave.csv"]
