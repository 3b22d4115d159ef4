"""Serve the page of a live ride: tokens, certificate, addresses, QR code.

Tokens are printed once and stored nowhere.
"""

from __future__ import annotations

import contextlib
import datetime
import functools
import io
import sys
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path

import qrcode

from cohelm.arrays import replace
from cohelm.cli.requests import DriveRequest
from cohelm.errors import CohelmError
from cohelm.live import Drive, DriveSetup, NextStorey
from cohelm.live.messages import Role
from cohelm.live.sessions.timeline import timeline_of_recording
from cohelm.robots import NO_DROP_PROTECTION
from cohelm.scenarios.scenario import robot_of
from cohelm.web.certificate import Tls, own_certificate
from cohelm.web.origins import VIEWER_PATH, address, is_loopback, names_of
from cohelm.web.page_files import BuiltPage, read_page
from cohelm.web.replay import replay_app, replay_server
from cohelm.web.server import listening, make_context, serve
from cohelm.web.server_context import ServerContext
from cohelm.web.signin import new_token

__all__ = ["qr_code", "read_page", "serve_ride", "show_recording"]


def show_recording(file: Path, page: BuiltPage, request: DriveRequest) -> None:
    """Show a recording in the page until interrupted.

    Args:
        file: MCAP file of a ride.
        page: Files of the page.
        request: Host and port.

    Raises:
        CohelmError: if the file, the host or the port cannot be used.
    """
    sys.stdout.write(f"reading {file}\n")

    def warn(text: str) -> None:
        sys.stderr.write(f"warning: {text}\n")

    timeline = timeline_of_recording(file, warn)
    app = replay_app(timeline, page, request.host)
    with listening(request.host, request.port) as bound:
        base = address(names_of(request.host)[0], int(bound.getsockname()[1]), tls=False)

        lines = [f"  replay     {base}/", "Press Ctrl-C to end."]
        started = functools.partial(_started, lines, base if request.open else "")
        replay_server(app, started).run(sockets=[bound])


def serve_ride(
    setup: DriveSetup,
    page: BuiltPage,
    request: DriveRequest,
    attach: Callable[[Drive], Callable[[], None]] | None = None,
    on_storey: Callable[[NextStorey], DriveSetup] | None = None,
) -> None:
    """Serve a ride until interrupted; on another storey the drive begins anew at the same address.

    Args:
        setup: Ride.
        page: Files of the page.
        request: Host, port and certificate.
        attach: Connects something else with the started drive, and returns how to end it.
        on_storey: Returns the ride on another storey of the building.

    Raises:
        CohelmError: if host, port, certificate or scenario cannot be used.
    """
    names = names_of(request.host)
    tls = _tls(setup, request, names)
    tokens: dict[Role, str] = {"therapist": new_token()}
    if not is_loopback(request.host):
        tokens["driver"] = new_token()
    with listening(request.host, request.port) as bound:
        base = address(names[0], int(bound.getsockname()[1]), tls=tls is not None)
        opens = base if request.open else ""
        context: ServerContext | None = None
        while True:
            drive, attached = Drive(setup), contextlib.ExitStack()
            try:
                if context is not None:  # who has signed in stays so
                    context, lines = replace(context, drive=drive), [setup.scenario.name]
                else:
                    context = make_context(
                        drive,
                        page,
                        bound,
                        host=request.host,
                        tokens=tokens,
                        tls=tls,
                        names=names,
                        viewers=request.viewer,
                    )
                    lines = _addresses(setup, base, tokens, tls, viewers=bool(request.viewer))
                drive.start()
                if attach is not None:
                    attached.callback(attach(drive))
                with bound.dup() as own:  # the server closes it at its end
                    serve(context, own, tls, functools.partial(_started, lines, opens))
            finally:
                attached.close()
                drive.close()
            if drive.next_storey is None or on_storey is None:
                return
            opens = ""
            try:
                setup = on_storey(drive.next_storey)
            except CohelmError as error:  # better on the old storey than nowhere
                sys.stderr.write(f"warning: {drive.next_storey.name}: {error}\n")


def _started(lines: list[str], opens: str) -> None:
    """Print lines, and open an address in a browser unless it is empty."""
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()
    if opens:
        threading.Thread(target=webbrowser.open, args=(opens,), daemon=True).start()


def qr_code(text: str) -> str:
    """QR code of ``text`` in half blocks, light on dark as most terminals are."""
    code = qrcode.QRCode(border=2, error_correction=qrcode.ERROR_CORRECT_L)
    code.add_data(text)
    drawn = io.StringIO()
    code.print_ascii(drawn, invert=True)
    return drawn.getvalue()


def _tls(setup: DriveSetup, request: DriveRequest, names: tuple[str, ...]) -> Tls | None:
    if request.cert is not None and request.key is not None:
        given = Tls(certificate=request.cert, key=request.key)
        given.context()
        return given
    if is_loopback(request.host) or setup.folder is None:
        return None
    return own_certificate(setup.folder / "tls", names, datetime.datetime.now(datetime.UTC))


def _addresses(
    setup: DriveSetup, base: str, tokens: dict[Role, str], tls: Tls | None, *, viewers: bool
) -> list[str]:
    driver = tokens.get("driver")
    page = f"{base}/" if driver is None else f"{base}/#token={driver}"
    lines = [
        f"{setup.scenario.name}, seed {setup.seed}",
        f"  drive      {page}",
        f"  therapist  {base}/therapist#token={tokens['therapist']}",
    ]
    if viewers:
        query = "" if driver is None else f"?token={driver}"
        lines.append(f"  Foxglove   {base.replace('http', 'ws', 1)}{VIEWER_PATH}{query}")
    if not robot_of(setup.scenario).sees_floor:
        lines.append(f"  {NO_DROP_PROTECTION}")
    if tls is not None:
        lines.append(f"  certificate, SHA-256  {tls.fingerprint()}")
    if driver is not None:
        lines += ["", qr_code(page)]
    return [*lines, "Press Ctrl-C to end."]
