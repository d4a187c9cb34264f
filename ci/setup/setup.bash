# Shared by ci/exec and ci/test: preparation of the workspace.

library=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
workspace=$(cd "$library/../.." && pwd -P)
os_release=/etc/os-release
state=$workspace/build/ci-exec

source "$library/usage.bash"
source "$library/ros.bash"
source "$library/environment.bash"
source "$library/needs.bash"
source "$library/packages.bash"
source "$library/build.bash"

say() { printf 'ci/%s: %s\n' "${0##*/}" "$*" >&2; }

die() {
    say "$@"
    exit 125
}

# Interval of progress messages of a long step on a terminal [s].
every=5
# Time without output after which a step is reported without a terminal [s].
stalled=30

user_name() { id -nu 2>/dev/null || id -u; }

# Run with all output in a log.
quietly() { # COMMAND…
    : >"$state/log"
    if [ -t 2 ]; then
        # The pipe ends with the command in any case.
        { "$@" >"$state/log" 2>&1 8>&-; } 8> >(show_progress)
    else
        { "$@" >"$state/log" 2>&1 8>&-; } 8> >(show_stalls)
    fi
}

# Report the progress of a log until the input ends.
show_progress() {
    local began=$SECONDS status line
    while status=0; do
        read -rt "$every" line || status=$?
        [ "$status" -gt 128 ] || return 0 # no time-out
        line=$(tail -n 1 "$state/log" | tr -d '[:cntrl:]')
        say "$((SECONDS - began)) s: ${line:0:72}"
    done
}

# Report a log that no longer grows, as when a network hangs, until the input ends.
show_stalls() {
    local began=$SECONDS size=0 before status line
    while status=0; do
        before=$size
        read -rt "$stalled" line || status=$?
        [ "$status" -gt 128 ] || return 0 # no time-out
        size=$(stat -c %s "$state/log")
        [ "$size" = "$before" ] || continue
        line=$(tail -n 1 "$state/log" | tr -d '[:cntrl:]')
        say "$((SECONDS - began)) s, and nothing new for $stalled s: ${line:0:72}"
    done
}

# The same, and show the log on failure.
logged() { # COMMAND…
    quietly "$@" && return
    cat "$state/log"
    return 1
}

# catkin and CMake paste paths into commands and lists, and rosrun splits them at spaces.
refuse_unfit_path() {
    local unfit=${workspace//[^[:space:][:cntrl:]\"\'\\\$\;#()&\[\]<>|\`:]/}
    [ -z "$unfit" ] ||
        die "ROS's tools cannot handle the '$unfit' in $workspace: move the workspace to a path without" \
            "spaces, quotes, colons and other characters that mean something to a shell."
}

# Another user's files, for example of a first run with sudo, would fail a build half-way.
refuse_foreign_files() {
    local me place
    local -a places=("$workspace/build" "$workspace/devel")
    me=$(user_name)
    place=$(find "${places[@]}" ! -type l ! -user "$me" ! -writable -print -quit 2>/dev/null || :)
    [ -z "$place" ] ||
        die "$place belongs to $(stat -c %U "$place"), and $me cannot change it: have root run" \
            "'chown -R $me $workspace/build $workspace/devel', or use a clone of your own."
    { mkdir -p "$state" && [ -w "$state" ] && : >>"$state/lock"; } 2>/dev/null ||
        die "$me cannot write to $state: have root run 'chown -R $me $workspace', or use a clone of your own."
}

# Install the packages of these sections and build, each only where needed.
# The check takes no lock; a run that has work to do waits for the lock and checks
# again. The lock's descriptor exists in the subshell only, so that the command
# never inherits it.
set_up() { # SECTION…
    find_ros
    clean_environment
    refuse_unfit_path
    if [ -z "$(missing_packages "$@")" ] && build_is_fresh; then
        return
    fi
    refuse_foreign_files
    (
        flock --nonblock 9 || {
            say "another command is setting up this workspace: waiting for it."
            flock 9
        }
        install_packages "$@"
        build_is_fresh || build
    ) 9>"$state/lock" </dev/null >&2
}

# Create build/NAME, an environment with a program from PyPI that Debian lacks, unless it exists.
fetch_tool() { # NAME REQUIREMENT
    local place=$workspace/build/$1
    [ "$(cat "$place/made" 2>/dev/null)" != "$2" ] || return 0
    say "fetching $2 from PyPI"
    rm -rf "$place"
    quietly python3 -m venv "$place" ||
        die "cannot create a virtual environment: $(tail -n 1 "$state/log")"
    # shellcheck disable=SC2086
    quietly "$place/bin/pip" install --quiet --retries 1 $2 ||
        die "$2 could not be installed from PyPI: $(tail -n 1 "$state/log")"
    echo "$2" >"$place/made"
}
