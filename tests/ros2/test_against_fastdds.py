"""cohelm's DDS against a third peer: a C++ program with Debian's Fast DDS that reads each field."""

import queue
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from cohelm.recordings.rides import ros_messages as ros
from cohelm.ros2.cdr import encode
from cohelm.ros2.dds import DdsNode
from cohelm.ros2.transport import Reliability
from tests.ros2.loopback import LOOPBACK
from tests.ros2.messages import scan

pytestmark = [pytest.mark.ros, pytest.mark.slow]
HEADER = Path("/usr/include/fastdds/dds/domain/DomainParticipant.hpp")
DOMAIN = 73
COUNT, IN_FLIGHT = 1000, 20
START = 60.0
"""Maximum time until both sides know each other, s."""
RELIABLE = Reliability(reliable=True, depth=100)
MADE = {
    "twist": lambda rng: ros.twist(rng.normal(size=3)),
    "laserscan": lambda rng: scan(
        float(rng.uniform(1.0, 1e6)), ranges=rng.uniform(0.1, 9.0, rng.integers(1, 1000))
    ),
}


@pytest.fixture(scope="module")
def echo(tmp_path_factory):
    if shutil.which("g++") is None or not HEADER.exists():
        pytest.skip("needs g++, libfastrtps-dev and libfastcdr-dev: 'make test-slow' installs them")
    program = tmp_path_factory.mktemp("echo") / "echo"
    source = Path(__file__).with_name("fastdds_echo.cpp")
    subprocess.run(
        ["g++", "-std=c++17", source, "-lfastrtps", "-lfastcdr", "-o", program], check=True
    )
    process = subprocess.Popen([program, str(DOMAIN)], stdin=subprocess.PIPE)
    yield process
    process.stdin.close()
    assert process.wait(10.0) == 0


@pytest.fixture(scope="module")
def connection(echo):
    """Publisher and received messages of each topic, connected with the echo."""
    dds = LOOPBACK.dds.model_copy(update={"domain": DOMAIN})
    node, send, back = DdsNode(dds, "cohelm"), {}, {}
    for name, make in MADE.items():
        kind, back[name] = make(np.random.default_rng(0)).__msgtype__, queue.SimpleQueue()
        node.subscribe(f"/echo/{name}", kind, RELIABLE, back[name].put)
        send[name] = node.publisher(f"/{name}", kind, RELIABLE)
    node.start()
    try:
        end = time.monotonic() + START
        while time.monotonic() < end and not all(
            node.matched(f"/echo/{name}") and node.subscribers(f"/{name}") for name in MADE
        ):
            time.sleep(0.1)
        assert all(node.matched(f"/echo/{name}") for name in MADE)
        time.sleep(1.0)  # the echo learns of both a little later
        yield send, back
    finally:
        node.close()


@pytest.mark.parametrize("name", MADE)
def test_of_a_thousand_messages_none_is_lost_or_changed(connection, name):
    send, back, rng = connection[0][name], connection[1][name], np.random.default_rng(1)
    sent, received = [], []
    for _ in range(COUNT):
        sent.append(MADE[name](rng))
        send(sent[-1])
        while len(sent) - len(received) > IN_FLIGHT:
            received.append(back.get(timeout=20.0))
    while len(received) < COUNT:
        received.append(back.get(timeout=20.0))
    assert [encode(each) for each in received] == [encode(each) for each in sent]
