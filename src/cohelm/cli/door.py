"""Opening the page's door: tokens, certificate, the ride behind it, and where to find it.

Tokens are said here, once, and kept nowhere.
"""

from __future__ import annotations

import datetime
import io
import sys
import threading
import webbrowser
from typing import TYPE_CHECKING

import qrcode

from cohelm.driving import Drive, DriveSetup
from cohelm.driving.messages import Role
from cohelm.web.built import BuiltPage, read_page
from cohelm.web.certificate import Tls, own_certificate
from cohelm.web.origins import is_loopback
from cohelm.web.reach import address, names_of
from cohelm.web.serve import listening, serve, serving
from cohelm.web.signin import new_token

if TYPE_CHECKING:
    from cohelm.cli.drive import Asked


def built_page() -> BuiltPage:
    """The page.

    Raises:
        ConfigError: if it has not been built.
    """
    return read_page()


def open_door(setup: DriveSetup, page: BuiltPage, asked: Asked) -> None:
    """Serve a ride until interrupted.

    Raises:
        CohelmError: if host, port, certificate or scenario are not to be had.
    """
    names = names_of(asked.host)
    tls = _tls(setup, asked, names)
    tokens: dict[Role, str] = {"therapist": new_token()}
    if not is_loopback(asked.host):
        tokens["driver"] = new_token()
    with listening(asked.host, asked.port) as bound:
        base = address(names[0], int(bound.getsockname()[1]), tls=tls is not None)
        drive = Drive(setup)
        try:
            what = serving(drive, page, bound, host=asked.host, tokens=tokens, tls=tls, names=names)
            drive.start()

            def started() -> None:
                _say(setup, base, tokens, tls)
                if asked.open:
                    threading.Thread(target=webbrowser.open, args=(base,), daemon=True).start()

            serve(what, bound, tls, started)
        finally:
            drive.close()


def _tls(setup: DriveSetup, asked: Asked, names: tuple[str, ...]) -> Tls | None:
    if asked.cert is not None and asked.key is not None:
        given = Tls(certificate=asked.cert, key=asked.key)
        given.context()
        return given
    if is_loopback(asked.host) or setup.folder is None:
        return None
    return own_certificate(setup.folder / "tls", names, datetime.datetime.now(datetime.UTC))


def _say(setup: DriveSetup, base: str, tokens: dict[Role, str], tls: Tls | None) -> None:
    driver = tokens.get("driver")
    page = f"{base}/" if driver is None else f"{base}/#token={driver}"
    lines = [
        f"{setup.scenario.name}, seed {setup.seed}",
        f"  drive      {page}",
        f"  therapist  {base}/therapist#token={tokens['therapist']}",
    ]
    if tls is not None:
        lines.append(f"  certificate, SHA-256  {tls.fingerprint()}")
    if driver is not None:
        lines += ["", qr_code(page)]
    lines.append("Ctrl-C ends it.")
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


def qr_code(text: str) -> str:
    """``text`` for a camera, as half blocks; light on dark, as terminals mostly are."""
    code = qrcode.QRCode(border=2, error_correction=qrcode.ERROR_CORRECT_L)
    code.add_data(text)
    drawn = io.StringIO()
    code.print_ascii(drawn, invert=True)
    return drawn.getvalue()
