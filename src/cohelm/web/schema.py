"""JSON Schema of the messages: published by the server, and the source of the page's types.

``python -m cohelm.web.schema`` writes it to ``messages.schema.json`` beside this file, as draft 7:
the generator of the TypeScript types knows no newer form of tuples.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from cohelm.evaluation.metrics.measures import measure_table
from cohelm.live.messages import FROM_PAGE, TO_PAGE, VERSION

FILE = Path(__file__).with_name("messages.schema.json")
MEASURES = Path(__file__).with_name("measures.json")
"""Names, units and directions of the measures, for the page."""
_REFERENCE = "#/definitions/"


def messages_schema() -> dict[str, Any]:
    """Return both unions under ``properties``: ``fromPage`` and ``toPage``.

    Messages of the server are complete, so all their fields are required. Messages of a page may
    leave out fields with a default, but never their ``type``.
    """
    schemas, shared = TypeAdapter.json_schemas(
        [("from", "validation", FROM_PAGE), ("to", "serialization", TO_PAGE)],
        ref_template=_REFERENCE + "{model}",
        schema_generator=_Draft7,
    )
    definitions: dict[str, Any] = shared["$defs"]
    unions = {
        "from": {"oneOf": schemas["from", "validation"]["oneOf"]},
        "to": {"oneOf": schemas["to", "serialization"]["oneOf"]},
    }
    whole = set(_reachable(unions["to"], definitions))
    for name, each in definitions.items():
        fields = each.get("properties", {})
        needed = {*each.get("required", ()), *({"type"} & fields.keys())}
        if fields:
            each["required"] = [key for key in fields if name in whole or key in needed]
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Messages",
        "description": f"What a page and the chair say to each other, version {VERSION}.",
        "type": "object",
        "properties": {"fromPage": unions["from"], "toPage": unions["to"]},
        "required": ["fromPage", "toPage"],
        "additionalProperties": False,
        "definitions": definitions,
    }


def as_text() -> str:
    """Return the schema as the text of its file."""
    return json.dumps(messages_schema(), indent=2, ensure_ascii=False) + "\n"


def measures_as_text() -> str:
    """Table of the measures as it is stored in the file."""
    return json.dumps(measure_table(), indent=2, ensure_ascii=False) + "\n"


class _Draft7(GenerateJsonSchema):
    """Generator that writes tuples as lists of fixed length, and no titles of fields.

    Each title would become a type of its own.
    """

    def tuple_schema(self, schema: core_schema.TupleSchema) -> JsonSchemaValue:
        made = super().tuple_schema(schema)
        each = made.pop("prefixItems", None)
        return made if each is None else {**made, "items": each}

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


def _reachable(schema: Any, definitions: dict[str, Any]) -> Iterator[str]:
    """Yield the names of all definitions that ``schema`` refers to, also indirectly."""
    if isinstance(schema, dict):
        name = str(schema.get("$ref", "")).removeprefix(_REFERENCE)
        if name:
            yield name
            yield from _reachable(definitions[name], definitions)
        for value in schema.values():
            yield from _reachable(value, definitions)
    elif isinstance(schema, list):
        for value in schema:
            yield from _reachable(value, definitions)


if __name__ == "__main__":
    FILE.write_text(as_text(), encoding="utf-8")
    MEASURES.write_text(measures_as_text(), encoding="utf-8")
