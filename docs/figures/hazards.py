"""Put the table of failure modes of a result folder into docs/results/safety.md.

cohelm bench faults --unwatched --out benches/faults
python docs/figures/hazards.py benches/faults
"""

from __future__ import annotations

import argparse
from pathlib import Path

BEGIN, END = "<!-- hazards: begin -->\n", "<!-- hazards: end -->\n"


def main() -> None:
    """Replace what stands between the two marks."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("folder", type=Path)
    options.add_argument("--page", type=Path, default=Path("docs/results/safety.md"))
    chosen = options.parse_args()
    table = (chosen.folder / "hazards.md").read_text(encoding="utf-8")
    page = chosen.page.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    chosen.page.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
