"""HTML reports from Jinja2 templates: one file without external resources, all text escaped.

A template of another package extends ``page.html`` and imports ``macros.html``::

    render("session.html", package="cohelm.live", title=…, rides=html.Table(…))
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

_HERE = "cohelm.evaluation.report"
_WORD = re.compile(r"[^\W\d_]{3}")
"""Three letters: longer than any unit."""


class TableCell(NamedTuple):
    """Cell of a table with small print."""

    text: str
    small: tuple[str, ...] = ()
    css: str = ""
    """Class of the text, as ``good``."""


Content = str | TableCell


@dataclass(frozen=True)
class Table:
    """Table that scrolls sideways; the first column heads its row."""

    columns: Sequence[str]
    rows: Sequence[Sequence[Content]]
    caption: str = ""
    emphasised: frozenset[int] = frozenset()
    """Rows in italics."""

    @property
    def alignment(self) -> list[str]:
        """Class of each column: ``words`` at the left, else empty: numbers at the right."""
        return [
            "words" if _is_words([row[i] for row in self.rows]) else ""
            for i in range(len(self.columns))
        ]


def render(template: str, package: str = _HERE, **context: Any) -> str:
    """Render a template from the folder ``templates`` of a package.

    Args:
        template: file name.
        package: package of the template; templates of this package are found too.
        context: values of the template; text is escaped unless it is ``markupsafe.Markup``.
    """
    return _environment(package).get_template(template).render(**context)


@lru_cache
def _environment(package: str) -> Environment:
    packages = dict.fromkeys((package, _HERE))
    return Environment(
        loader=ChoiceLoader([PackageLoader(each) for each in packages]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _is_words(column: Sequence[Content]) -> bool:
    given = [each for each in column if each]
    return bool(given) and all(isinstance(each, str) and _WORD.search(each) for each in given)
