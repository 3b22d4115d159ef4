"""Flood of connections as a program of its own: ``flood.py PORT HELD``, the text on standard input.

It keeps HELD connections open, and opens each again that is dropped, at most 4,000 times; it says
so once they are open, and ends when it is killed.
"""

import contextlib
import socket
import sys
import time

MOST = 4000


def main() -> None:
    """Open connections and send the text on each."""
    port, held, text = int(sys.argv[1]), int(sys.argv[2]), sys.stdin.buffer.read()
    open_: list[socket.socket] = []
    told = False
    for _ in range(MOST):
        with contextlib.suppress(OSError):
            made = socket.create_connection(("127.0.0.1", port), 0.5)
            made.setblocking(False)
            open_.append(made)
            if text:
                made.send(text)
        if len(open_) == held and not told:
            sys.stdout.write("started\n")
            sys.stdout.flush()
            told = True
        if len(open_) >= held:
            open_.pop(0).close()
            time.sleep(0.002)
    time.sleep(60.0)


if __name__ == "__main__":
    main()
