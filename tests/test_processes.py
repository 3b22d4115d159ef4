"""No process of our own outlives the one that it belongs to."""

import subprocess
import sys
import time
from pathlib import Path

OWNER = """
import time
from cohelm.processes import end_with_owner, spawn

def busy():
    end_with_owner()
    print("busy", flush=True)
    while True:
        time.sleep(0.01)

if __name__ == "__main__":
    process = spawn.Process(target=busy, daemon=True)
    process.start()
    print(process.pid, flush=True)
    time.sleep(60.0)
"""


def test_who_is_busy_ends_when_its_owner_is_killed(tmp_path):
    script = tmp_path / "owner.py"
    script.write_text(OWNER, encoding="utf-8")
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as owner:
        pid = int(owner.stdout.readline())
        assert owner.stdout.readline() == "busy\n"
        owner.kill()
    end = time.monotonic() + 10.0
    while _lives(pid) and time.monotonic() < end:
        time.sleep(0.02)
    assert not _lives(pid)


def _lives(pid):
    """Whether it runs; who has ended and is not yet buried does not."""
    try:
        said = Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    except OSError:
        return False
    return said.rpartition(")")[2].split()[0] != "Z"
