"""Parameters of a robot on this computer; nothing else, so that small processes start fast."""

from cohelm.ros2.parameters import DdsParameters, Ros2Parameters

LOOPBACK = Ros2Parameters(dds=DdsParameters(interface="lo"), wait=60.0)
