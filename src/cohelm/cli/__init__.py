"""The command line; it starts fast because every command imports its work when it is called."""

from cohelm.cli.app import main

__all__ = ["main"]
