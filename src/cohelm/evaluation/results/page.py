"""The page around a report: one HTML file that asks the net for nothing, light and dark."""

from __future__ import annotations

from importlib.resources import files

from cohelm.evaluation.results.markup import Content, Markup, tag, text


def page(title: str, *content: Content) -> Markup:
    """A whole document."""
    style = (files(__package__) / "page.css").read_text(encoding="utf-8")
    head = tag(
        "head",
        Markup('<meta charset="utf-8">'),
        Markup('<meta name="viewport" content="width=device-width,initial-scale=1">'),
        tag("title", title),
        tag("style", Markup(style)),
    )
    body = tag("body", tag("main", *content))
    return Markup(f'<!DOCTYPE html>\n<html lang="en">{head}{body}</html>\n')


def section(name: str, title: str, *content: Content) -> Markup:
    """A part of the page with an address; nothing where it has no content."""
    inside = text(content)
    return tag("section", tag("h2", title), inside, id=name) if inside else Markup("")
