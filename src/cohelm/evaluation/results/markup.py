"""HTML that cannot be broken by what it shows: text is escaped unless it is markup already."""

from __future__ import annotations

import re
from collections.abc import Iterable
from html import escape


class Markup(str):
    """Text that is HTML."""

    __slots__ = ()


Content = str | Iterable["Content"]
"""Text, markup, or several of them."""
_VOID = frozenset({"br", "img"})
"""Elements that hold nothing and have no end."""
_WORD = re.compile(r"[^\W\d_]{3}")
"""No unit is as long."""


def tag(name: str, *content: Content, **attributes: str | None) -> Markup:
    """An element; an attribute's trailing underscore is dropped, None leaves it out."""
    given = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(each)}"'
        for key, each in attributes.items()
        if each is not None
    )
    end = "" if name in _VOID else f"</{name}>"
    return Markup(f"<{name}{given}>{text(content)}{end}")


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
    """A table that scrolls sideways where it is too wide; the first column heads its row.

    Columns of words begin at the left, those of figures end at the right.
    """
    lines = [list(row) for row in rows]
    heads = list(columns)
    looks = ["words" if _is_of_words(row[i] for row in lines) else None for i in range(len(heads))]
    head = [
        tag("th", each, scope="col", class_=look) for each, look in zip(heads, looks, strict=True)
    ]
    body = [
        tag(
            "tr",
            tag("th", row[0], scope="row"),
            [tag("td", each, class_=look) for each, look in zip(row[1:], looks[1:], strict=True)],
        )
        for row in lines
    ]
    says = tag("caption", tag("span", caption)) if caption else ""
    inner = tag("table", says, tag("thead", tag("tr", head)), tag("tbody", body))
    return tag("div", inner, class_="wide", tabindex="0")


def _is_of_words(column: Iterable[Content]) -> bool:
    said = [each for each in column if each]
    plain = [each for each in said if isinstance(each, str) and not isinstance(each, Markup)]
    return bool(said) and len(plain) == len(said) and all(map(_WORD.search, plain))


def folded(title: Content, *content: Content) -> Markup:
    """Content behind a line that opens it."""
    return tag("details", tag("summary", title), *content)
