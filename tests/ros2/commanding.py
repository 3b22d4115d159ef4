"""Process that sends a forward command 20 times a second, as the control loop does.

python -m tests.ros2.commanding [rclpy]
"""

import sys
import time


def main():
    # Inside, since the process of the command topic imports this module again.
    from cohelm.errors import PlatformError
    from cohelm.ros2.command_client import CommandClient
    from cohelm.ros2.command_process import WheelCommand, publisher
    from cohelm.ros2.transport import make_node
    from tests.ros2.loopback import LOOPBACK

    transport = sys.argv[1] if len(sys.argv) > 1 else "dds"
    parameters = LOOPBACK.model_copy(update={"transport": transport})
    node = make_node(parameters, "owner")
    fallback = publisher(node, parameters)
    node.start()
    client = CommandClient(parameters, fallback)
    sys.stdout.write(f"{client.pid}\n")
    sys.stdout.flush()
    while True:
        try:
            # A busy computer may hold up the process for a moment before the test begins.
            forward = 0.0 if client.late else 0.5
            client.send(WheelCommand(time.monotonic(), time.time(), (forward, 0.0, 0.0)))
        except PlatformError as error:
            sys.stdout.write(f"{error}\n")
            sys.stdout.flush()
            time.sleep(0.5)
            return
        time.sleep(0.05)


if __name__ == "__main__":
    main()
