# The ROS 1 to build upon: one that the caller has sourced, one in /opt/ros, or the distribution's
# packages. The first two are complete, and apt installs no ROS packages.

opt_ros=/opt/ros

# Set by find_ros: prefix of a separate ROS, or nothing; and its Python.
ros=
python=/usr/bin/python3

find_ros() {
    local prefix
    local -a sourced
    IFS=: read -ra sourced <<<"${CMAKE_PREFIX_PATH-}"
    # Of those in /opt/ros, first the last release.
    for prefix in "${sourced[@]}" "$opt_ros/noetic" "$opt_ros"/*; do
        # A workspace, such as our own devel, has a setup.bash but not rospy.
        if [ -f "$prefix/setup.bash" ] && [ -f "$prefix/share/rospy/package.xml" ]; then
            ros=$prefix
            # A ROS in an environment, such as conda's, has its own Python.
            [ ! -x "$ros/bin/python3" ] || python=$ros/bin/python3
            break
        fi
    done
}

# Report it once for a build: apt's output does not show it.
tell_ros() {
    [ -z "$ros" ] || say "building upon the ROS in $ros, with $python"
}

refuse_old_python() {
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 8))' ||
        die "$python is older than Python 3.8, which the workspace needs."
}
