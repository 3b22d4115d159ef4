"""The language of the code: docstrings open with a noun or a verb, and a name means one thing."""

import ast
import re
from collections import defaultdict
from pathlib import Path

import cohelm
from tests.test_structure import trees

SOURCE = Path(cohelm.__file__).parent
PROJECT = Path(__file__).parent.parent
DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
FORBIDDEN = re.compile(r"(What|How|Whether|Who|Whom|Whose|Where|Which|Of|The same)\b")
SHARE = 0.01
"""Of docstrings that may open with one of these words."""
IDIOMS = {"Parameters"}
"""Class names that Python or the plugins want nested or repeated."""


def test_docstrings_open_with_a_noun_or_a_verb():
    found = [
        (f"{file.relative_to(SOURCE)}:{getattr(node, 'lineno', 1)}", text.splitlines()[0])
        for file, tree in trees().items()
        for node in ast.walk(tree)
        if isinstance(node, DOCUMENTED) and (text := ast.get_docstring(node))
    ]
    forbidden = [each for each in found if FORBIDDEN.match(each[1])]
    assert len(forbidden) <= SHARE * len(found), forbidden


def test_a_public_class_name_means_one_class():
    defined = defaultdict(list)
    for file, tree in trees().items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                defined[node.name].append(str(file.relative_to(SOURCE)))
    assert {n: f for n, f in defined.items() if len(f) > 1 and n not in IDIOMS} == {}


def test_the_glossary_is_sorted_and_linked():
    glossary = (PROJECT / "docs" / "glossary.md").read_text(encoding="utf-8")
    terms = re.findall(r"^\| \*\*(.+?)\*\* \|", glossary, flags=re.MULTILINE)
    assert len(terms) > 60
    assert terms == sorted(terms, key=str.casefold)
    assert "docs/glossary.md" in (PROJECT / "README.md").read_text(encoding="utf-8")
