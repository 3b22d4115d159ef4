"""A ride with a person at the stick: a live chair, whoever drives it, and what keeps it safe.

    page ─► link ─► observation ─► navigator (a process of its own) ─► decision ─► chair
                 └───────────── watchdog: zero, whoever fails ──────────────┘

It serves nothing and draws nothing; ``cohelm.web`` carries its messages to a page.
"""

from cohelm.driving.drive import Drive, Health, Listener
from cohelm.driving.limits import LimitsRise
from cohelm.driving.setup import PACES, DriveSetup

__all__ = ["PACES", "Drive", "DriveSetup", "Health", "LimitsRise", "Listener"]
