#!/usr/bin/env bash
# Usage: move-ros.bash PREFIX
#
# Move Debian's ROS 1 into a separate prefix, like those of Noetic and ROS One. For a temporary
# system. catkin_pkg and rospkg, which such a ROS finds in /usr, stay there.
set -euo pipefail
prefix=$1
# catkin's own file is too old for CMake 4 without this setting.
export CMAKE_POLICY_VERSION_MINIMUM=3.5

# catkin generates the setup files when it installs a workspace without packages.
mkdir -p /tmp/empty/src
(cd /tmp/empty && catkin_make -DCMAKE_INSTALL_PREFIX="$prefix" install)
rm -r /tmp/empty

# shellcheck disable=SC2016
mapfile -t packages < <(dpkg-query -W -f '${source:Package} ${Package}\n' | awk '
    $1 ~ /^ros-/ && $1 !~ /^ros-(catkin-pkg|catkin-tools|osrf-pycommon|rospkg)$/ { print $2 }')
dpkg -L "${packages[@]}" | grep -E '^/(usr|etc/(catkin|ros))/' | grep -v '^/usr/share/doc/' | sort -u |
    while read -r file; do
        target=$prefix${file#/usr}
        if [ -d "$file" ] && [ ! -L "$file" ]; then mkdir -p "$target"; else cp -a "$file" "$target"; fi
    done
mapfile -t files < <(grep -rl /usr --include='*.cmake' --include='*.pc' "$prefix")
sed -i -e "s,/usr\b,$prefix,g" -e "s,$prefix/\(local\|bin/python\|bin/env\),/usr/\1,g" "${files[@]}"
dpkg --purge --force-depends "${packages[@]}"
