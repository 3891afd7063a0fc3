"""The keys of a kind of FMU as Markdown, from the pydantic models that read them."""

from __future__ import annotations

from inspect import cleandoc
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from m4e_fmi.files.document import Section

WORDS = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true, false"}


def schema_text(title: str, config: type[Section]) -> str:
    """A heading, and for each section what its docstring says and a table of its keys."""
    schema = config.model_json_schema(mode="validation", by_alias=True)
    sections = {config.__name__: schema, **schema.get("$defs", {})}
    all_models = models(config)
    parts = [f"## {title}\n"]
    for name, section in sections.items():
        if name != config.__name__:
            parts.append(f"### {title}: {name}\n")
        parts.append(f"{cleandoc(all_models[name].__doc__ or '')}\n")
        parts.append("| key | value | default |\n|---|---|---|")
        for key, value in section.get("properties", {}).items():
            field = _fields(all_models[name])[key]
            parts.append(f"| `{key}` | {_value(value, title)} | {_default(field)} |")
        parts.append("")
    return "\n".join(parts)


def models(config: type[BaseModel]) -> dict[str, type[BaseModel]]:
    """`config` and all models below it, by name."""
    found: dict[str, type[BaseModel]] = {}

    def visit(annotation: Any) -> None:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            if annotation.__name__ not in found:
                found[annotation.__name__] = annotation
                for field in annotation.model_fields.values():
                    visit(field.annotation)
            return
        for part in getattr(annotation, "__args__", ()):
            visit(part)

    visit(config)
    return found


def _fields(model: type[BaseModel]) -> dict[str, FieldInfo]:
    return {field.alias or name: field for name, field in model.model_fields.items()}


def _value(value: dict[str, Any], title: str) -> str:
    """What may stand behind a key."""
    if "$ref" in value:
        name = value["$ref"].rpartition("/")[2]
        return f"[{name}](#{title}-{name.lower()})"
    for union in ("anyOf", "oneOf"):
        if union in value:
            kinds = (_value(v, title) for v in value[union] if v.get("type") != "null")
            return " or ".join(dict.fromkeys(kinds))
    if "const" in value or "enum" in value:
        return ", ".join(f"`{word}`" for word in value.get("enum", [value.get("const")]))
    if value.get("type") == "array" and "prefixItems" not in value:
        return f"[{_value(value['items'], title)}, …]"
    if value.get("type") == "array":
        return f"[{', '.join(_value(v, title) for v in value['prefixItems'])}]"
    if value.get("type") == "object":
        patterns = value.get("patternProperties") or {"": value["additionalProperties"]}
        members = next(iter(patterns.values()))
        return f"name: {_value(members, title)}, …"
    return WORDS[value["type"]] + _limits(value)


def _limits(value: dict[str, Any]) -> str:
    signs = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
    told = [f"{sign} {value[key]:g}" for key, sign in signs.items() if key in value]
    return f" {', '.join(told)}" if told else ""


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "**required**"
    value = field.get_default(call_default_factory=True)
    if isinstance(value, Section) and _is_whole(value):
        return "its own"
    if value is None or value in ({}, ()) or isinstance(value, Section):
        return "–"
    if isinstance(value, float):
        return "`deep`" if value == float("inf") else f"{value:g}"
    return f"`{value}`"


def _is_whole(value: Section) -> bool:
    """True for a section that could be written as it is."""
    try:
        type(value).model_validate(value.model_dump(exclude_none=True))
    except ValidationError:
        return False
    return True
