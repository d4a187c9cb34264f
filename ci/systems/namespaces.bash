# Shared by ci/clean-room, ci/container and ci/deb: temporary namespaces and a temporary directory.

die() {
    echo "ci/${0##*/}: $*" >&2
    exit 125
}

# Set a variable for each option, --NAME VALUE, and suites to the rest; each part must exist.
read_options() { # ALL-PARTS,… "NAME…" ARGUMENT…
    local all=$1 names=$2 name part
    shift 2
    for name in $names; do declare -g "$name="; done
    only=$all suites=()
    while [ $# -gt 0 ]; do
        if [[ $1 != -* ]]; then
            suites+=("$1")
            shift
            continue
        fi
        name=${1#--}
        [[ " $names " == *" $name "* ]] || help_or_refuse "$1"
        [[ ${2-} == *[!,]* ]] || die "--$name takes a name, or names separated by commas."
        declare -g "$name=$2"
        shift 2
    done
    for part in ${only//,/ }; do
        [[ ,$all, == *,"$part",* ]] || die "unknown part '$part': must be one of ${all//,/, }."
    done
}

# Run a command as the first process of new namespaces, with a directory before its arguments.
in_namespaces() { # COMMAND ARGUMENT…
    local program
    [ "$EUID" = 0 ] || die "only root can bootstrap a system."
    for program in debootstrap unshare nsenter ip git; do
        command -v "$program" >/dev/null ||
            die "needs $program: apt-get install debootstrap util-linux iproute2 git"
    done
    room=${room-$(mktemp -d)}
    trap leave EXIT
    trap 'exit 130' INT
    trap 'exit 143' TERM
    set -m # a background job would ignore Ctrl-C otherwise, and its children with it
    unshare --mount --mount-proc --pid --fork --kill-child "$1" "$room" "${@:2}" </dev/null &
    inside=$!
    wait "$inside"
}

leave() {
    trap '' INT TERM
    # The end of the namespace's first process ends all others and the mounts.
    if first=$(cat "/proc/${inside-}/task/${inside-}/children" 2>/dev/null); then
        kill -KILL "${first% }" || :
        wait "$inside" || :
    fi
    rm -rf --one-file-system "$room"
}
