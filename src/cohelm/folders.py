"""The user's folders, after the XDG base directory specification."""

from __future__ import annotations

import os
from pathlib import Path

from cohelm.errors import ConfigError


def user_folder(variable: str, *below_home: str) -> Path | None:
    """Folder ``cohelm`` in the one that a variable names, or at its default place below the home.

    A relative path in the variable is ignored. None: there is no home folder either, as for a user
    id without an entry in the password file.
    """
    given = Path(os.environ.get(variable, ""))
    if given.is_absolute():
        return given / "cohelm"
    try:
        return Path.home().joinpath(*below_home, "cohelm")
    except RuntimeError:
        return None


def data_folder(name: str) -> Path:
    """Folder of the user's data of one kind: ``$XDG_DATA_HOME/cohelm/name``.

    Raises:
        ConfigError: if there is neither the variable nor a home folder.
    """
    folder = user_folder("XDG_DATA_HOME", ".local", "share")
    if folder is None:
        raise ConfigError(f"no home folder for {name}: set HOME or XDG_DATA_HOME")
    return folder / name
