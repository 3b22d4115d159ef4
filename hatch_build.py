"""A wheel brings the built page along; one without it is refused rather than found out later."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PAGE = "src/cohelm/web/page/index.html"
WITHOUT = "COHELM_WITHOUT_PAGE"


class PageHook(BuildHookInterface[Any]):
    """Looks for the page before a wheel is built; an editable installation may come first."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Refuse to build where the page is missing."""
        built = (Path(self.root) / PAGE).is_file()
        if self.target_name == "wheel" and version != "editable" and not built:
            if not os.environ.get(WITHOUT):
                raise RuntimeError(
                    f"the page has not been built ({PAGE} is missing): run 'make page' first, "
                    f"or set {WITHOUT}=1 for a wheel that cannot 'cohelm drive'"
                )
            self.app.display_warning("a wheel without the page: 'cohelm drive' will not work")
