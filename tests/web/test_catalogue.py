"""The page's English catalogue has the chair's own sentences, so that it can translate them."""

import json
import re
from pathlib import Path

import pytest

from cohelm.reasons import OfferReason, Reason

CATALOGUE = Path(__file__).parents[2] / "page/src/i18n/en/chair.ts"
LINE = re.compile(r'^  ("(?:[^"\\]|\\.)+"): ("(?:[^"\\]|\\.)*"),$', re.MULTILINE)


@pytest.fixture(scope="module")
def english():
    return {json.loads(key): json.loads(text) for key, text in LINE.findall(CATALOGUE.read_text())}


@pytest.mark.parametrize("reason", [*Reason])
def test_every_reason_is_there_word_by_word(english, reason):
    assert english[f"reason.{reason.value}"] == reason.sentence


@pytest.mark.parametrize("reason", [*OfferReason])
def test_every_reason_of_an_offer_is_there_word_by_word(english, reason):
    assert english[f"offer.{reason.value}"] == reason.sentence
