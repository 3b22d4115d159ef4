"""HTML that cannot be broken by what it shows: text is escaped unless it is markup already."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


class Markup(str):
    """Text that is HTML."""

    __slots__ = ()


Content = str | Iterable["Content"]
"""Text, markup, or several of them."""


def tag(name: str, *content: Content, **attributes: str | None) -> Markup:
    """An element; an attribute's trailing underscore is dropped, None leaves it out."""
    given = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(each)}"'
        for key, each in attributes.items()
        if each is not None
    )
    return Markup(f"<{name}{given}>{text(content)}</{name}>")


def text(content: Content) -> Markup:
    """Content as markup."""
    if isinstance(content, Markup):
        return content
    if isinstance(content, str):
        return Markup(escape(content))
    return Markup("".join(text(each) for each in content))


def table(
    columns: Iterable[Content], rows: Iterable[Iterable[Content]], caption: Content = ""
) -> Markup:
    """A table that scrolls sideways where it is too wide; the first column heads its row."""
    head = tag("tr", [tag("th", each, scope="col") for each in columns])
    body = [
        tag("tr", [tag("th" if not i else "td", each) for i, each in enumerate(row)])
        for row in rows
    ]
    says = tag("caption", tag("span", caption)) if caption else ""
    inner = tag("table", says, tag("thead", head), tag("tbody", body))
    return tag("div", inner, class_="wide", tabindex="0")


def folded(title: Content, *content: Content) -> Markup:
    """Content behind a line that opens it."""
    return tag("details", tag("summary", title), *content)
