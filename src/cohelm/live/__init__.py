"""Live ride: a person drives a chair, with everything that keeps the ride safe.

    page ─► link ─► observation ─► navigator (own process) ─► decision ─► chair
                 └──────────── watchdog: stop, whatever fails ─────────────┘

``messages`` are the protocol with a page, ``control`` has the parts around the navigator, ``page``
translates between them, and ``sessions`` stores the rides. ``cohelm.web`` serves the page.
"""

from cohelm.live.control.limits import PACES, LimitsLoosened
from cohelm.live.drive import Drive, DriveHealth, DriveSetup, Listener

__all__ = ["PACES", "Drive", "DriveHealth", "DriveSetup", "LimitsLoosened", "Listener"]
