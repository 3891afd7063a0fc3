"""Files in general: YAML with line numbers, CSV columns, names, locks, safe writes.

Start with `document` for YAML, whose parts become the pydantic models of `sections`, which has the
texts of errors, too. `csv_columns` reads tables. Files are written by `writing`, under `locks`
where others may write them too; `files_read` records what was read. `limits` has the limits of all
input files; XML and ZIP archives are checked by `xml_text` and `archives`. Errors of input name
file, line and column.
"""
