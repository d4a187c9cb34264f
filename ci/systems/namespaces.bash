# Shared by ci/clean-room, ci/container and ci/deb: namespaces and a directory, of which nothing stays behind.

die() {
    echo "ci/${0##*/}: $*" >&2
    exit 125
}

# Of what --only names, each has to be a part that there is; with none, all would seem good.
judge_parts() { # PART,… ALL-PARTS,…
    local part
    [[ $1 == *[!,]* ]] || die "--only takes names of parts, separated by commas: ${2//,/, }."
    for part in ${1//,/ }; do
        [[ ,$2, == *,"$part",* ]] || die "unknown part '$part': must be one of ${2//,/, }."
    done
}

# Run a command as the first process of namespaces of its own, with a directory before its arguments.
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
    # When the namespace's first process goes, so do all others and the mounts.
    if first=$(cat "/proc/${inside-}/task/${inside-}/children" 2>/dev/null); then
        kill -KILL "${first% }" || :
        wait "$inside" || :
    fi
    rm -rf --one-file-system "$room"
}
