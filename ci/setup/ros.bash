# Which ROS 1 the workspace is built upon: one that the caller has sourced, or one in /opt/ros, or
# the distribution's own packages. The first two bring all of ROS, and apt installs nothing of it.

opt_ros=/opt/ros

# Set by find_ros: where a ROS of its own stands, or nothing; and the Python that it belongs to.
ros=
python=/usr/bin/python3

find_ros() {
    local prefix
    local -a sourced
    IFS=: read -ra sourced <<<"${CMAKE_PREFIX_PATH-}"
    # Of those in /opt/ros, first the last release.
    for prefix in "${sourced[@]}" "$opt_ros/noetic" "$opt_ros"/*; do
        # What is built upon one, such as our own devel, has a setup.bash but no rospy.
        if [ -f "$prefix/setup.bash" ] && [ -f "$prefix/share/rospy/package.xml" ]; then
            ros=$prefix
            # One in an environment of its own, such as conda's, has its own Python.
            [ ! -x "$ros/bin/python3" ] || python=$ros/bin/python3
            break
        fi
    done
}

# Say it once for a build, as none of this shows in what apt does.
tell_ros() {
    [ -z "$ros" ] || say "building upon the ROS in $ros, with $python"
}

refuse_old_python() {
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 8))' ||
        die "$python is older than Python 3.8, which the workspace needs."
}
