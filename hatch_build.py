"""A wheel brings the built page along, and compiled kernels where "make wheel" compiled some."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PAGE = "src/cohelm/web/page/index.html"
WITHOUT = "COHELM_WITHOUT_PAGE"
KERNELS = "COHELM_KERNELS"
"""Folder of a complete cache of kernels, compiled for x86-64-v3."""


class PageHook(BuildHookInterface[Any]):
    """Adds what is built before the wheel; an editable installation may come first."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Refuse to build where the page is missing; add the kernels if there are any."""
        if self.target_name != "wheel" or version == "editable":
            return
        if not (Path(self.root) / PAGE).is_file():
            if not os.environ.get(WITHOUT):
                raise RuntimeError(
                    f"the page has not been built ({PAGE} is missing): run 'make page' first, "
                    f"or set {WITHOUT}=1 for a wheel that cannot 'cohelm drive'"
                )
            self.app.display_warning("a wheel without the page: 'cohelm drive' will not work")
        if os.environ.get(KERNELS):
            self._add_kernels(Path(os.environ[KERNELS]).resolve(), build_data)

    def _add_kernels(self, folder: Path, build_data: dict[str, Any]) -> None:
        """Include a cache in the package: the wheel is for this Python and Linux on x86-64."""
        manifest = folder / "compiled.txt"
        if not manifest.is_file():
            raise RuntimeError(f"{folder} is no complete cache: run 'cohelm compile' first")
        for file in (manifest, *sorted(folder.rglob("*.nb[ci]"))):
            build_data["force_include"][str(file)] = f"cohelm/{file.relative_to(folder)}"
        build_data["pure_python"] = False
        build_data["tag"] = "cp{}{}-none-linux_x86_64".format(*sys.version_info)
