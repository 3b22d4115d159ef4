"""The price of a wish is waited for, but not for ever."""

import pytest

from cohelm.driving import pricing
from cohelm.driving.asking import Ready
from cohelm.driving.messages import Want


class Mute:
    """A process that is ready and then says nothing more."""

    made = 0

    def __init__(self, *_):
        Mute.made += 1
        self.says = [Ready(done=True)]

    def receive(self, timeout):
        return self.says.pop() if self.says else None

    def send(self, message):
        pass

    def kill(self):
        pass


@pytest.mark.parametrize(("patience", "refused"), [(-1.0, 1), (1e9, 0)])
def test_a_process_that_hangs_is_begun_anew_and_its_question_refused(
    monkeypatch, patience, refused
):
    monkeypatch.setattr(pricing, "Remote", Mute)
    monkeypatch.setattr(pricing, "HANGING", patience)
    told, made = [], Mute.made
    asked = pricing.Pricing(None, lambda message, client: told.append((message.code, client)))
    asked.begin()
    asked.attend()
    asked.ask("a", Want(id=3, kind="attract", points=((1.0, 2.0),), preview=True))
    assert asked.wanted
    asked.surrounded(b"about")
    asked.attend()
    asked.begin()
    assert told == refused * [("no_preview", "a")]
    assert Mute.made - made == 1 + refused
