#!/usr/bin/env bash
# Usage: clean-room-inside.bash DIRECTORY PART,… TIER,… SUITE…
#
# The part of ci/clean-room that runs in namespaces.
set -euo pipefail
me=ci/clean-room
source "$(dirname "${BASH_SOURCE[0]}")/clean-system.bash"

# Longest time to the first sample, and to an error [s].
limit=120
limit_of_refusal=60

# Two users, and the workspace in their folders.
furnish() { # ROOT
    chroot "$1" useradd --create-home --shell /bin/bash student &&
        chroot "$1" useradd --create-home --shell /bin/bash teacher &&
        clone "$1" student workspace && clone "$1" student "a folder" && clone "$1" teacher workspace
}

clone() { # ROOT USER FOLDER
    local home=/home/$2
    git clone --quiet --no-hardlinks "$workspace" "$1$home/$3" &&
        git -C "$1$home/$3" checkout --quiet --detach "$commit" &&
        chroot "$1" chown -R "$2:" "$home/$3"
}

# Folder in a user's home for commands.
place=workspace

# Expect a user's command to end soon with 125 and a sentence with certain words.
refuses() { # WORDS ROOT USER online|offline COMMAND…
    local words=$1 status=0 began=$SECONDS
    shift
    (within "$@") >"$log" 2>&1 || status=$?
    words="^(ci/|make_environment:).*$words"
    [ "$status" = 125 ] && grep -qE "$words" "$log" && [ $((SECONDS - began)) -lt "$limit_of_refusal" ] &&
        say "refused as expected: $(grep -E "$words" "$log" | cut -c 1-150)" && return
    say "status $status after $((SECONDS - began)) s; expected 125 with '$words' of: ${*:2}"
    end_of_log
    return 1
}

# Expect that a command prints the installation commands, and run them as root; apt asks once.
by_hand() { # ROOT COMMAND…
    local lines
    refuses "packages are missing" "$1" student online env CI_EXEC_NO_INSTALL=1 "${@:2}" || return
    lines=$(grep -v '^ci/' "$log")
    say "as root: $(cut -c 1-150 <<<"$lines")"
    succeeds "$1" root online env DEBIAN_FRONTEND=noninteractive sh -ec "$lines" < <(yes)
}

install_sudo() { # ROOT
    succeeds "$1" root online sh -c \
        'apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends sudo' &&
        echo 'teacher ALL=(ALL:ALL) NOPASSWD: ALL' >"$1/etc/sudoers.d/teacher" &&
        drop_lists "$1"
}

take_refusals() { # SUITE ROOT
    furnish "$2" &&
        place='a folder' refuses "cannot handle the ' ' in" "$2" student online ./ci/exec true &&
        refuses "without sudo only root" "$2" student online ./ci/exec true &&
        install_sudo "$2" &&
        refuses "sudo did not let student install" "$2" student online ./ci/exec true &&
        refuses "no package can be downloaded" "$2" teacher offline ./ci/exec true &&
        verdict="each with the right message"
}

# A clone in a user's own workspace, with only the packages that ci/exec prints.
take_workspace() { # SUITE ROOT
    local command first=:
    command=$(page_commands docs/tutorials/other_packages.md "All of it in your own workspace" | head -n 1)
    # CMake 4 accepts catkin's files only with this setting.
    [ "$1" != forky ] || first="export CMAKE_POLICY_VERSION_MINIMUM=3.5"
    furnish "$2" && clone "$2" student my_ws/src/basic_comms && chroot "$2" chown student: /home/student/my_ws{,/src} &&
        by_hand "$2" ./ci/exec true &&
        # The clone of the command's first part exists already.
        succeeds "$2" student offline bash -c "$first; ${command#*&& }" &&
        says_once "tests are left out" &&
        succeeds "$2" student offline bash -c 'source ~/my_ws/devel/setup.bash && rospack find basic_comms' &&
        verdict="built with what ci/exec printed"
}

# A new package is built with the packages of ci/exec, and passes its test with those of ci/test.
take_package() { # SUITE ROOT
    furnish "$2" &&
        by_hand "$2" ./ci/exec true &&
        succeeds "$2" student offline ./ci/exec sh -ec \
            'mkdir -p ~/new_ws/src; cd ~/new_ws; rosrun nodekit new first_robot; catkin_make' &&
        says_once "tests are left out" &&
        by_hand "$2" ./ci/test &&
        succeeds "$2" student offline ./ci/exec sh -ec \
            'cd ~/new_ws; catkin_make --force-cmake run_tests; catkin_test_results --all build; find build | grep "rosunit-.*xml"' &&
        verdict="built, and its test passed"
}

# The distribution's ROS moved to a separate prefix: sourced there, then found in /opt/ros by a
# system without apt.
take_prefix() { # SUITE ROOT
    local command
    command=$(launch_command)
    furnish "$2" && by_hand "$2" sh -c "exec $command" || return
    say "$1: moving ROS to /srv/ros"
    cp "$workspace/ci/systems/move-ros.bash" "$2/root" &&
        succeeds "$2" root offline bash /root/move-ros.bash /srv/ros &&
        launches "$2" student "source /srv/ros/setup.bash; ${command/ roslaunch / roslaunch --files }" &&
        says_once "building upon the ROS in /srv/ros," &&
        chroot "$2" sh -ec 'mkdir /opt/ros; ln -s /srv/ros /opt/ros/own; rm /usr/bin/apt-get /usr/bin/dpkg-query' &&
        launches "$2" student "${command/ roslaunch / roslaunch --files }" &&
        says_once "building upon the ROS in /opt/ros/own," &&
        says_once "without apt nothing is installed here.* cmake g++" &&
        verdict="sourced; and in /opt/ros, without apt"
}

# README's first command.
launch_command() { page_commands README.md "Two commands" | head -n 1; }

# Prepare, then launch until a second command receives from the process node. The build is part of the
# preparation: a timeout during it would restart it.
launches() { # ROOT USER PREPARATION
    say "$3; $command"
    # shellcheck disable=SC2016
    succeeds "$1" "$2" offline bash -c "$3 && { $command & }; launch=\$! SECONDS=0"'
        until timeout 60 ./ci/exec rostopic echo -n 1 /proc_signal; do
            kill -0 "$launch" && [ "$SECONDS" -lt 600 ] && sleep 1 || { kill "$launch"; exit 1; }
        done
        echo "received after $SECONDS"
        kill "$launch"; wait "$launch"'
}

# Expect words in one line of the last command's output.
says_once() { # WORDS
    [ "$(grep -c "$1" "$log")" = 1 ] && return
    say "expected '$1' once of the last command"
    end_of_log
    return 1
}

# From the first command until a second command receives from the process node.
take_launch() { # SUITE ROOT
    local began ready seconds command
    command=$(launch_command)
    furnish "$2" && install_sudo "$2" || return
    began=$SECONDS
    say "$1: what '$command' needs"
    # The same command with another last step: it names the files, and needs no network then.
    succeeds "$2" teacher online sh -c "exec ${command/ roslaunch / roslaunch --files }" || return
    ready=$((SECONDS - began))
    cat "$log" >&2
    # The only master is the launched one.
    if (within "$2" teacher offline ./ci/exec rosnode list) >"$log" 2>&1; then
        verdict="there was a master before anything was launched"
        return 1
    fi
    verdict="no sample on /proc_signal within $limit s"
    launches "$2" teacher : || return
    seconds=$((ready + $(sed -n 's/^received after //p' "$log")))
    verdict="first sample after $seconds s, ready to launch after $ready s, of at most $limit s"
    [ "$seconds" -lt "$limit" ]
}

take_test() { # SUITE ROOT
    local command
    command=$(page_commands README.md "Two commands" | tail -n 1)
    furnish "$2" || return
    if [ "$tiers" ]; then
        run_tests "$1" "$2" offline "$command ${tiers//,/ }"
    else
        # The second: other tiers that need no network.
        run_tests "$1" "$2" offline "$command" &&
            run_tests "$1" "$2" offline "$command ci install catkin_build extended --without lint"
    fi
}

# The environment with ROS 2 is fetched from PyPI.
take_ros2() { # SUITE ROOT
    furnish "$2" && run_tests "$1" "$2" online "./ci/test ros2"
}

# Not as root, and without sudo.
run_tests() { # SUITE ROOT online|offline COMMAND
    say "$1: what '$4' needs"
    by_hand "$2" sh -c "exec $4" || return
    say "$1: $4"
    (within "$2" student "$3" sh -c "exec $4") 2>&1 | tee "$log" || {
        verdict="tests: $(tail -n 1 "$log")"
        return 1
    }
    verdict="tests: $(tail -n 1 "$log")"
}

main() { # DIRECTORY PART,… TIER,… SUITE…
    local room=$1 parts=$2 tiers=$3 commit mirror
    shift 3
    commit=$(git -C "$workspace" rev-parse HEAD)
    take_parts "$parts" "$@"
}

# A function, so that bash has read the whole file before it runs. (Tests source it.)
[ "${BASH_SOURCE[0]}" != "$0" ] || main "$@"
