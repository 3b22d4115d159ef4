"""ROS 2 robot as a platform, without a ROS installation: Cyclone DDS, with CDR by ``rosbags``.

    topics ─► conversions ─► inputs ─► Observation          Decision ─► command process ─► /cmd_vel

``transport`` is the network: ``dds`` with ``message_types``, or ``rclpy_node``; ``cdr`` makes the
bytes. ``conversions`` and ``frames`` are pure, ``inputs`` keeps the newest messages, ``findings``
and ``checking`` are ``cohelm ros2 --check``, ``platform`` joins them. The command topic belongs to
a process of its own, see ``command_process``.
"""
