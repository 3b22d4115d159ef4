"""A ride with a person at the stick: a live chair, whoever drives it, and what keeps it safe.

    page ─► link ─► observation ─► navigator (a process of its own) ─► decision ─► chair
                 └───────────── watchdog: zero, whoever fails ──────────────┘

It serves nothing and draws nothing; ``cohelm.web`` carries its messages to a page.
"""
