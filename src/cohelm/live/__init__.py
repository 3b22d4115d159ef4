"""Live ride: a person drives a chair, with everything that keeps the ride safe.

    page ─► link ─► observation ─► navigator (own process) ─► decision ─► chair
                 └──────────── watchdog: stop, whatever fails ─────────────┘

``messages`` are the protocol with a page, ``commands`` puts them into effect, ``control`` has the
parts around the navigator, whose process also makes the messages that pages show, ``page`` has the
route previews, and ``sessions`` stores the rides. ``cohelm.web`` serves the page.

    drive      one run of the program, from ``Drive.start`` to ``Drive.close``
    session    the rides of one drive and rider
    world      the simulation from one seed; a restart begins another one in the same drive
    ride       from the first motion to arrival, contact or cancellation
    mission    what the driver has requested: destination, wishes, mode and pace
    tick       one step of 0.05 s: observation, decision, motion

    thread or process    file                          owns                         ends
    web server (caller)  drive.py, cohelm.web          sockets of the pages         with the program
    its thread pool      rider_choice.py, sessions     riders and stored sessions   with the program
    thread control       control_loop.py               driver state, control cycle  Drive.close
    thread world         control/world_factory.py      a world being built          world built
    thread sessions      sessions/store.py             writes of stored rides       Drive.close
    thread measuring     sessions/store.py             the measuring process        Drive.close
    thread audit         sessions/audit.py             the audit log                Drive.close
    process navigator    control/navigator_process.py  navigator, ride log, MCAP    pipe closed
    its thread ride-log  sessions/ride_log.py          file of the ride's log       pipe closed
    process previews     page/preview_process.py       planner of previews          pipe closed
    process compiler     preparation.py                kernels, at a first start    all compiled
    process measuring    sessions/measuring.py         measures, map of a ride      ride measured

Threads share values through queues, under a lock, or by replacing an attribute as a whole;
processes get and return values through a pipe, the navigator those of ``control/ipc.py``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
