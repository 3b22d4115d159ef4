"""Folder that only its owner can read, used by one program at a time."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from cohelm.errors import StoreError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]  # tested below


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


def unwritable(file: Path, cause: OSError) -> StoreError:
    """Return the error for a file or folder that cannot be written."""
    return StoreError(f"cannot be written ({cause.strerror or cause})", file=file)
