# The environment of the distribution's ROS 1.

# ROS's Python modules belong to /usr/bin/python3: exclude every other python.
clean_environment() {
    local path=/usr/sbin:/usr/bin:/sbin:/bin directory
    local -a directories
    IFS=: read -ra directories <<<"${PATH-}"
    for directory in "${directories[@]}"; do
        case $directory in '' | /usr/sbin | /usr/bin | /sbin | /bin) continue ;; esac
        # pyenv's shims, a venv, conda: anything with its own python.
        [ -x "$directory/python3" ] || [ -x "$directory/python" ] || path=$path:$directory
    done
    export PATH=$path
    unset PYTHONHOME VIRTUAL_ENV CONDA_PREFIX CONDA_DEFAULT_ENV PYENV_VERSION

    # A directory of the user's own modules is harmless. A directory of installed packages
    # belongs to another python or another ROS, with modules that would hide ours.
    path=
    IFS=: read -ra directories <<<"${PYTHONPATH-}"
    for directory in "${directories[@]}"; do
        case $directory in
            '' | *-packages | *-packages/) ;;
            *) path=${path:+$path:}$directory ;;
        esac
    done
    if [ -n "$path" ]; then export PYTHONPATH=$path; else unset PYTHONPATH; fi

    # catkin's own CMake files are too old for CMake 4 without this setting.
    export CMAKE_POLICY_VERSION_MINIMUM=${CMAKE_POLICY_VERSION_MINIMUM-3.5}

    # Without any locale the Python of Debian's ROS reads files as ASCII.
    [ -n "${LC_ALL-}${LC_CTYPE-}${LANG-}" ] || export LANG=C.UTF-8
}

source_setup() { # PREFIX: an installed ROS or a catkin devel space
    local setup=$1/setup.bash
    # catkin's setup files interpret positional parameters as options, read
    # unset variables and continue after failing commands.
    set --
    set +eu
    # shellcheck disable=SC1090
    source "$setup"
    set -eu
}

# Set the environment of the built workspace for the next command.
enter_workspace() {
    source_setup "$workspace/devel"
    case ${ROS_MASTER_URI-} in
        '' | *://*) ;;
        *) say "ROS_MASTER_URI is $ROS_MASTER_URI, which needs http:// in front:" \
            "'export ROS_MASTER_URI=http://$ROS_MASTER_URI'." ;;
    esac
    if [ -z "${ROS_IP-}${ROS_HOSTNAME-}" ]; then
        # roscore and rospy then listen on the loopback device only. (Set but
        # empty, either would count as a name.)
        unset ROS_IP
        export ROS_HOSTNAME=localhost
        case ${ROS_MASTER_URI-} in
            '' | *://localhost:* | *://127.*) ;;
            *://*) say "ROS_MASTER_URI is $ROS_MASTER_URI, but nodes started here cannot be" \
                "reached from there: set ROS_IP or ROS_HOSTNAME to this machine's." ;;
        esac
    fi
}

# Reject a command that would use another user's master, unless ROS_MASTER_URI selects it: on a shared
# machine, their nodes may have the same names, and ours would end them.
refuse_foreign_master() { # CHOSEN_URI COMMAND…
    local chosen=$1
    shift
    local uri=${ROS_MASTER_URI:-http://localhost:11311} port word owner free
    [[ $uri =~ ^https?://(localhost|127\.[0-9.]+|\[::1\]):([0-9]+)/?$ ]] || return 0
    port=${BASH_REMATCH[2]}
    case ${1-} in
        roslaunch | roscore)
            for word; do
                # -p PORT, --port PORT, --port=PORT
                [[ $port == next && $word =~ ^[0-9]+$ ]] && port=$word
                [[ $word == -p || $word == --port ]] && port=next
                [[ $word =~ ^(--port=|-p)([0-9]+)$ ]] && port=${BASH_REMATCH[2]}
            done
            ;;
    esac
    [[ $port =~ ^[0-9]+$ ]] || return 0
    # Read all output of listeners: SIGPIPE would end it, and with it ci/exec.
    owner=$(listeners | awk -v port="$port" '$1 == port && !seen++ { print $2 }')
    if [ -z "$owner" ] || [ "$owner" = "$(id -u)" ]; then return 0; fi
    free=$(listeners | awk -v port="$port" '{ taken[$1] } END { while (++port in taken); print port }')
    say "port $port of this machine is used by $(id -nu "$owner" 2>/dev/null || echo "user $owner"), not by" \
        "you: for a master of your own, 'export ROS_MASTER_URI=http://localhost:$free' in each terminal."
    if [ -n "$chosen" ]; then return 0; fi
    case ${1-} in
        true | catkin*) ;; # only builds
        *)
            say "nothing was started: nodes of yours could end theirs. To use their master all the same," \
                "'export ROS_MASTER_URI=http://127.0.0.1:$port'."
            exit 125
            ;;
    esac
}

# The listening TCP ports of this machine: port and user, a line each.
listeners() {
    local state address uid port
    while read -r _ address _ state _ _ _ uid _; do
        port=$((16#${address##*:}))
        [ "$state" != 0A ] || echo "$port $uid"
    done < <(tail -q -n +2 /proc/net/tcp /proc/net/tcp6 2>/dev/null)
}
