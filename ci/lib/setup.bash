# Shared by ci/exec and ci/test: what makes a workspace ready to run in.

library=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
workspace=$(cd "$library/../.." && pwd -P)
noetic=/opt/ros/noetic
state=$workspace/build/ci-exec

source "$library/environment.bash"
source "$library/packages.bash"
source "$library/build.bash"

say() { printf 'ci/%s: %s\n' "${0##*/}" "$*" >&2; }

die() {
    say "$@"
    exit 125
}

# Run with all output in a log that is shown only on failure.
logged() { # COMMAND…
    "$@" >"$state/log" 2>&1 && return
    cat "$state/log"
    return 1
}

# Install the packages of these sections and build, each only where needed.
# Looking takes no lock; whoever finds something to do waits for the lock and
# looks again. The lock's descriptor lives in the subshell alone, so that the
# command never inherits it.
set_up() { # SECTION…
    clean_environment
    if [ -z "$(missing_packages "$@")" ] && build_is_fresh; then
        return
    fi
    mkdir -p "$state" || die "cannot write to $workspace/build."
    (
        flock --nonblock 9 || {
            say "another one is setting this workspace up: waiting for it."
            flock 9
        }
        install_packages "$@"
        build_is_fresh || build
    ) 9>"$state/lock" </dev/null >&2
}
