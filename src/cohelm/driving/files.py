"""Files that only their owner reads, and that are whole or not there."""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
from pathlib import Path

from cohelm.errors import StoreError

try:
    import fcntl
except ImportError:  # not everywhere
    fcntl = None  # type: ignore[assignment]  # nor its functions


def own_folder(folder: Path) -> Path:
    """The folder, made where it is missing, and closed to everybody else (0700).

    Raises:
        StoreError: if there can be none.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.chmod(0o700)
    except OSError as cause:
        raise unwritable(folder, cause) from None
    return folder


def reserved(folder: Path) -> int:
    """A handle that keeps others from using the folder until it is closed, or the program ends.

    Raises:
        StoreError: if somebody uses it, or it cannot be written to.
    """
    file = own_folder(folder) / ".in-use"
    try:
        handle = os.open(file, os.O_RDWR | os.O_CREAT, 0o600)
    except OSError as cause:
        raise unwritable(file, cause) from None
    if fcntl is None:
        return handle
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as cause:
        os.close(handle)
        if cause.errno not in {errno.EAGAIN, errno.EACCES}:
            raise unwritable(file, cause) from None
        what = "is in use by another drive; end that one, or name another folder (--data)"
        raise StoreError(what, file=folder) from None
    return handle


def write_whole(file: Path, content: bytes) -> None:
    """Put ``content`` in place of what the file held: all of it, or nothing of it (0600).

    Raises:
        StoreError: if the folder is not there, or the disk takes no more.
    """
    try:
        handle, name = tempfile.mkstemp(dir=file.parent, prefix=f".{file.name}.")
    except OSError as cause:
        raise unwritable(file, cause) from None
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        Path(name).replace(file)
        _settle(file.parent)
    except OSError as cause:
        raise unwritable(file, cause) from None
    finally:
        with contextlib.suppress(OSError):
            Path(name).unlink()


def unwritable(file: Path, cause: OSError) -> StoreError:
    """What is wrong with a file or folder, in words."""
    return StoreError(f"cannot be written ({cause.strerror or cause})", file=file)


def _settle(folder: Path) -> None:
    """Let the folder remember its new names even if the power fails."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
