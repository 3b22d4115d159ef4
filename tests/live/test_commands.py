"""Every message of a page has one handler."""

from typing import get_args

from cohelm.live.commands import HANDLERS
from cohelm.live.messages import Echo, FromPage


def test_every_message_of_a_page_has_a_handler_and_echo_needs_none():
    union, _ = get_args(FromPage)
    assert set(get_args(union)) == {*HANDLERS, Echo}
