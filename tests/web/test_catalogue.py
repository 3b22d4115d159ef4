"""The page's English catalogue has every sentence of the server, so that it can translate them."""

import ast
import json
import re
from pathlib import Path

import pytest

from cohelm.reasons import OfferReason, Reason

ROOT = Path(__file__).parents[2]
CATALOGUE = ROOT / "page/src/i18n/en/chair.ts"
LINE = re.compile(r'^  ("(?:[^"\\]|\\.)+"): ("(?:[^"\\]|\\.)*"),$', re.MULTILINE)
SOURCES = ROOT / "src/cohelm"
ELSEWHERE = {
    "live/compilation.py": "progress in the terminal",
    "live/control/navigator_client.py": "log",
    "live/control/worker_process.py": "log",
    "live/page/display_messages.py": "ROS viewers",
    "live/sessions/report.py": "a document in the language of the chair",
    "live/sessions/timeline.py": "warnings in the terminal",
    "web/certificate.py": "errors before the server starts",
    "web/page_files.py": "errors before the server starts",
    "web/replay.py": "errors before the server starts",
    "web/schema.py": "title of the schema",
    "web/server.py": "errors before the server starts",
}
"""Files whose texts no page shows."""
NO_TEXT = {
    "unknown (the log cannot be read)",  # stands for the name of a scene
    "of an older version, not read",
    "is of an older version; remove it, and set the limits again on the page",  # at the start
    "the settings are damaged",
    " {'wss' if tls else 'ws'}://{host}",
    "{'__Host-' if self.origins.tls else ''}cohelm-{self.port}",
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; sandbox",
    "{given} is no address of a site, as https://app.foxglove.dev",  # before the server starts
    "You have arrived: {goal.name}.",  # the page says it by the card of the ride
}
PROSE = re.compile(r"[A-Za-z]{2,}[,;]? [a-z]{2,}")
HEADER = re.compile(
    r"max-age=|charset=|filename=|\b(SELECT|INSERT|UPDATE|DELETE|PRAGMA|WHERE|VALUES)\b"
)
TRANSLATED = ("reason.", "offer.", "notice.", "refused.", "unstored.")
"""Beginnings of the keys that ``serverText`` in the page looks up."""


@pytest.fixture(scope="module")
def english():
    return {json.loads(key): json.loads(text) for key, text in LINE.findall(CATALOGUE.read_text())}


@pytest.mark.parametrize("reason", [*Reason])
def test_every_reason_is_there_word_by_word(english, reason):
    assert english[f"reason.{reason.value}"] == reason.sentence


@pytest.mark.parametrize("reason", [*Reason])
def test_a_reason_is_worded_for_the_therapist_where_it_addresses_the_rider(reason):
    text = CATALOGUE.with_name("status.ts").read_text()
    english = {json.loads(key): json.loads(said) for key, said in LINE.findall(text)}
    about = english.get(f"about.reason.{reason.value}", reason.sentence)
    assert about == reason.report
    assert not re.search(r"\b(you|please|tap)\b", about, re.IGNORECASE)


@pytest.mark.parametrize("reason", [*OfferReason])
def test_every_reason_of_an_offer_is_there_word_by_word(english, reason):
    assert english[f"offer.{reason.value}"] == reason.sentence


def test_no_sentence_of_the_server_bypasses_it(english):
    # As xgettext does it: a literal that looks like prose is a text, its fields count by position.
    sent = [text for key, text in english.items() if key.startswith(TRANSLATED)]
    known = {_sentence(_nameless(text)) for text in sent}
    files = [*SOURCES.glob("live/**/*.py"), *SOURCES.glob("web/*.py")]
    found = [
        f"{name}:{line}: {text}"
        for file in files
        if (name := file.relative_to(SOURCES).as_posix()) not in ELSEWHERE
        for line, text in _texts(file)
        if _sentence(_nameless(text)) not in known
    ]
    assert found == []
    assert len(files) > 60
    assert all((SOURCES / name).is_file() for name in ELSEWHERE)


def _texts(file):
    """(line, text) of every literal in a module that looks like prose; an f-string has fields."""
    tree = ast.parse(file.read_text())
    skipped = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            skipped |= {each.value for each in node.body if isinstance(each, ast.Expr)}
        if isinstance(node, ast.Call) and ast.unparse(node.func).startswith("_log."):
            skipped |= set(ast.walk(node))
        if isinstance(node, ast.JoinedStr):
            skipped |= set(node.values)
    for node in ast.walk(tree):
        text = _text(node)
        prose = PROSE.search(text) and not HEADER.search(text)
        if prose and node not in skipped and text not in NO_TEXT:
            yield node.lineno, text


def _text(node):
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        parts = node.values
        return "".join(
            part.value if isinstance(part, ast.Constant) else f"{{{ast.unparse(part.value)}}}"
            for part in parts
        )
    return ""


def _nameless(text):
    return re.sub(r"\{[^{}]*\}", "{}", text)


def _sentence(text):
    """A text as the page compares it: see ``sentence`` in ``page/src/i18n/text.svelte.ts``."""
    return text[:1].upper() + text[1:] + ("" if re.search(r'[.!?"”]$', text) else ".")
