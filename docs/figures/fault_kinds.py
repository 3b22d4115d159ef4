"""Put the kinds of faults, with the units and bounds of their magnitudes, into docs/safety.md.

python docs/figures/fault_kinds.py
"""

from __future__ import annotations

import math
from pathlib import Path

from cohelm.simulation import FAULT_KINDS

PAGE = Path(__file__).parents[1] / "safety.md"
BEGIN, END = "<!-- fault kinds: begin -->\n", "<!-- fault kinds: end -->\n"


def table() -> str:
    """Every kind as a row of a Markdown table."""
    rows = ["| kind | cause | unit of the magnitude | bounds | default |", "|---|---|---|---|---|"]
    for name, kind in FAULT_KINDS.items():
        low, high = kind.bounds
        if not kind.unit:
            magnitude = "– | – | –"
        elif math.isinf(high):
            least = "any" if math.isinf(low) else f"≥ {low:g}"
            magnitude = f"{kind.unit} | {least} | {kind.typical:g}"
        else:
            magnitude = f"{kind.unit} | {low:g} … {high:g} | {kind.typical:g}"
        rows.append(f"| `{name}` | {kind.text} | {magnitude} |")
    return "\n".join(rows) + "\n"


def main() -> None:
    """Replace what stands between the two marks."""
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    PAGE.write_text(f"{before}{BEGIN}\n{table()}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
