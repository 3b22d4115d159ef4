"""Entry point: run one command, and turn any failure into one line and an exit status.

Exit status: 0 the goal was reached or the command did its work, 1 the ride failed, 2 bad input.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from typing import Annotated, Any

import typer

from cohelm.cli import bench_commands, commands, streams
from cohelm.errors import CohelmError

BAD_INPUT = 2
INTERRUPTED = 130
"""128 + SIGINT, as shells have it."""

app = typer.Typer(
    name="cohelm",
    help="Shared control for wheelchairs among people: the rider and the chair steer together.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.add_typer(commands.app)
app.add_typer(bench_commands.app)

_USAGE_ERROR: type[Exception] = typer.BadParameter.__mro__[2]  # ClickException of click or of typer


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command and exit with its status."""
    streams.prepare()
    sys.exit(status(sys.argv[1:] if arguments is None else arguments))


def status(arguments: Sequence[str]) -> int:
    """Run one command; returns the exit status."""
    warnings.showwarning = _warn
    try:
        result = app(args=list(arguments), prog_name="cohelm", standalone_mode=False)
        sys.stdout.flush()
    except typer.Exit as leave:
        return leave.exit_code
    except typer.Abort:
        result = INTERRUPTED
    except _USAGE_ERROR as error:
        text = error.format_message() if hasattr(error, "format_message") else str(error)
        return _refuse(text or "no command given; see cohelm --help")
    except CohelmError as error:
        return _refuse(str(error))
    except (OSError, MemoryError, KeyboardInterrupt) as error:
        return _stopped(error)
    if result == INTERRUPTED:  # typer returns it for an interrupt
        return _stopped(KeyboardInterrupt())
    return result if isinstance(result, int) else 0


def _stopped(error: BaseException) -> int:
    """Exit status where the environment, not the input, ended the command."""
    if isinstance(error, KeyboardInterrupt):
        streams.say("interrupted")
        return INTERRUPTED
    if isinstance(error, MemoryError):
        return _refuse("not enough memory; use a smaller map")
    streams.drop_output()
    if isinstance(error, BrokenPipeError):  # as after `cohelm … | head`
        return streams.BROKEN_PIPE
    problem = f"cannot be read or written ({getattr(error, 'strerror', None) or error})"
    return _refuse(f"{getattr(error, 'filename', None) or 'output or working folder'}: {problem}")


def _warn(message: Warning | str, *where: Any, **options: Any) -> None:
    streams.say(f"warning: {message}")


def _refuse(text: str) -> int:
    streams.say(f"error: {text}")
    return BAD_INPUT


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        sys.stdout.write(f"cohelm {version('cohelm')}\n")
        sys.stdout.flush()
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    pass
