#!/usr/bin/env bash
# Usage: clean-room-inside.bash DIRECTORY SUITE…
#
# The part of ci/clean-room that runs in namespaces of its own.
set -euo pipefail
workspace=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)
room=$1
shift

# The time that the first sample may take, s.
limit=120
# Where the clone lies in the clean system.
clone=/opt/workspace

say() { printf 'ci/clean-room: %s\n' "$*" >&2; }

# The mirror of the Debian archive that this machine's apt uses.
find_mirror() {
    local targets
    # shellcheck disable=SC2016
    targets=$(apt-get indextargets --format '$(LABEL)|$(REPO_URI)' 'Created-By: Packages')
    IFS='|' read -r _ mirror < <(grep '^Debian|' <<<"$targets") || {
        say "apt on this machine has no Debian mirror, or no lists: try apt-get update."
        exit 125
    }
}

# What this machine needs to reach its mirror, the clean system needs as well.
copy_apt_settings() { # ROOT
    apt-config dump | grep -E '^Acquire::(https?::|Check-|Retries)' >"$1/etc/apt/apt.conf.d/90clean-room" || :
    local file
    sed -n 's/.*:CaInfo "\(.*\)";/\1/p' "$1/etc/apt/apt.conf.d/90clean-room" | while read -r file; do
        install -D -m 644 "$file" "$1/$file"
    done
}

bootstrap() { # SUITE ROOT
    local cached=${CLEAN_ROOM_CACHE:+$CLEAN_ROOM_CACHE/$1.tar}
    mkdir "$2" || return
    if [ -f "$cached" ]; then
        tar -C "$2" -xf "$cached" || return
    else
        say "$1: debootstrap from $mirror"
        debootstrap --variant=minbase "$1" "$2" "$mirror" \
            >"$room/$1.log" 2>&1 || {
            tail -n 20 "$room/$1.log" >&2
            return 1
        }
        [ -z "$cached" ] || tar -C "$2" -cf "$cached" .
    fi
    copy_apt_settings "$2" &&
        printf '127.0.0.1 localhost\n127.0.1.1 %s\n' "$(hostname)" >"$2/etc/hosts" &&
        mount -t proc proc "$2/proc" &&
        mount -t devpts -o newinstance,ptmxmode=666 devpts "$2/dev/pts" &&
        ln -sf pts/ptmx "$2/dev/ptmx" &&
        mount -t tmpfs -o mode=1777 shm "$2/dev/shm" &&
        git clone --quiet --no-hardlinks "$workspace" "$2$clone" &&
        git -C "$2$clone" checkout --quiet --detach "$commit"
}

# Run in the clean system, with nothing of this machine's environment but a proxy.
within() { # ROOT COMMAND…
    local root=$1 name
    local -a environment=(HOME=/root TERM=dumb PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin)
    shift
    for name in http_proxy https_proxy no_proxy; do
        [ -z "${!name-}" ] || environment+=("$name=${!name}")
    done
    exec env -i "${environment[@]}" chroot "$root" sh -c "cd $clone && exec \"\$@\"" sh "$@"
}

# From the first command until a second one hears the process node.
first_sample() { # SUITE ROOT
    local began=$SECONDS launch heard=no
    say "$1: ci/exec roslaunch basic_comms cw1.launch"
    (within "$2" ci/exec roslaunch basic_comms cw1.launch >"$room/$1.launch.log" 2>&1) &
    launch=$!
    while [ $((SECONDS - began)) -lt "$limit" ] && kill -0 "$launch" 2>/dev/null; do
        sleep 1
        if (within "$2" timeout "$limit" ci/exec rostopic echo -n 1 /proc_signal) >"$room/$1.echo.log" 2>&1; then
            heard=yes
            break
        fi
    done
    seconds=$((SECONDS - began))
    kill -INT "$launch" 2>/dev/null || :
    wait "$launch" || :
    [ "$heard" = yes ] && [ "$seconds" -lt "$limit" ] && return
    tail -n 30 "$room/$1.launch.log" "$room/$1.echo.log" >&2
    return 1
}

check() { # SUITE
    local root=$room/$1 seconds=none
    # Formatters and documentation tools differ from release to release, and
    # bullseye has no catkin-tools.
    local -a tiers=(unit install integration)
    [ "$1" = bullseye ] || tiers+=(catkin_build)
    [ "$1" != bookworm ] || tiers=()
    bootstrap "$1" "$root" || return
    first_sample "$1" "$root" || {
        verdict="no sample on /proc_signal within $limit s"
        return 1
    }
    say "$1: /proc_signal is heard $seconds s after the first command"
    (within "$root" ci/test "${tiers[@]}") 2>&1 | tee "$room/$1.test.log" || {
        verdict="first sample after $seconds s; tests: $(tail -n 1 "$room/$1.test.log")"
        return 1
    }
    verdict="first sample after $seconds s; tests: $(tail -n 1 "$room/$1.test.log")"
}

main() { # SUITE…
    local suite verdict word commit status=0
    local -a summary
    commit=$(git -C "$workspace" rev-parse HEAD)
    find_mirror
    for suite; do
        verdict="no system to test on"
        if check "$suite"; then word=ok; else word=FAILED status=1; fi
        summary+=("$(printf '%-6s %-10s %s' "$word" "$suite" "$verdict")")
    done
    printf '%s\n' "${summary[@]}"
    exit "$status"
}

# A function, so that nothing of this file is still to be read while it runs.
main "$@"
