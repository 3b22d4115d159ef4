"""Files that only their owner can read, written atomically."""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
from pathlib import Path

from cohelm.errors import StoreError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]  # tested below

_PROBE_SIZE = 65_536
"""Size of a file that must fit on the disk, bytes: a ride of some ten seconds."""


def make_private_folder(folder: Path) -> Path:
    """Create a missing folder that only its owner can read (0700).

    One that exists keeps its mode, since it may be shared with others: files in it are 0600.

    Raises:
        StoreError: The folder cannot be created.
    """
    if folder.is_dir():
        return folder
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.chmod(0o700)
    except OSError as cause:
        raise unwritable(folder, cause) from None
    return folder


def lock_folder(folder: Path) -> int:
    """Lock a folder until the returned handle is closed, or the program ends.

    Raises:
        StoreError: Another program uses it, or it cannot be written.
    """
    file = make_private_folder(folder) / ".in-use"
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


def write_atomically(file: Path, content: bytes) -> None:
    """Replace the content of a file atomically (0600).

    Raises:
        StoreError: The folder is missing, or the disk is full.
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
        _fsync_folder(file.parent)
    except OSError as cause:
        raise unwritable(file, cause) from None
    finally:
        with contextlib.suppress(OSError):
            Path(name).unlink()


def check_writable(folder: Path) -> None:
    """Check that a folder takes a file of some size.

    Raises:
        StoreError: It is missing or read-only, or the disk is full.
    """
    file = folder / ".probe"
    write_atomically(file, bytes(_PROBE_SIZE))
    with contextlib.suppress(OSError):
        file.unlink()


def unwritable(file: Path, cause: OSError) -> StoreError:
    """Return the error for a file or folder that cannot be written."""
    return StoreError(f"cannot be written ({cause.strerror or cause})", file=file)


def _fsync_folder(folder: Path) -> None:
    """Flush the folder's entries to disk, against a power failure."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
