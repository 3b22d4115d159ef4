"""Under which addresses a server is found: by who sits before it, and by who sits elsewhere."""

from __future__ import annotations

import ipaddress
import socket

from cohelm.web.origins import LOOPBACK, is_everywhere, is_loopback, plain

_ELSEWHERE = ("192.0.2.1", 9)
"""An address of documentation: asking for the way there sends nothing."""


def names_of(host: str) -> tuple[str, ...]:
    """Names and addresses that a certificate of a server on ``host`` must be good for.

    The first is the one to be told to people.
    """
    if is_loopback(host):
        first = "127.0.0.1" if host.lower() == "localhost" else plain(host)
        return tuple(dict.fromkeys((first, *LOOPBACK)))
    if not is_everywhere(host):
        return (plain(host),)
    found = (own_address(), socket.gethostname().lower(), *LOOPBACK)
    return tuple(dict.fromkeys(name for name in found if name))


def own_address() -> str:
    """The address by which this machine goes to its network; empty where it has none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asked:
        try:
            asked.connect(_ELSEWHERE)
        except OSError:
            return ""
        return str(asked.getsockname()[0])


def address(name: str, port: int, *, tls: bool) -> str:
    """What to type into a browser, without a slash at its end."""
    scheme, usual = ("https", 443) if tls else ("http", 80)
    try:
        bare = f"[{name}]" if ipaddress.ip_address(name).version == 6 else name
    except ValueError:
        bare = name
    return f"{scheme}://{bare}" + ("" if port == usual else f":{port}")
