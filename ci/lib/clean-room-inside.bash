#!/usr/bin/env bash
# Usage: clean-room-inside.bash DIRECTORY PART,… TIER,… SUITE…
#
# The part of ci/clean-room that runs in namespaces of its own.
set -euo pipefail
workspace=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)

# The time that the first sample may take, and a refusal, s.
limit=120
limit_of_refusal=60

say() { printf 'ci/clean-room: %s\n' "$*" >&2; }

# README's two commands, a line each, without their comments.
readme_commands() {
    awk '
        /^## / { here = ($0 == "## Two commands") }
        /^```/ { block = here && !block; next }
        block { sub(/ +#.*/, ""); if (NF) print }
    ' "$workspace/README.md"
}

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
    local packed=${CLEAN_ROOM_CACHE:-$room}/$1.tar
    mkdir "$2" || return
    if [ -f "$packed" ]; then
        tar -C "$2" -xf "$packed" || return
    else
        say "$1: debootstrap from $mirror"
        debootstrap --variant=minbase "$1" "$2" "$mirror" >"$log" 2>&1 || {
            end_of_log
            return 1
        }
        tar -C "$2" -cf "$packed.new" . && mv "$packed.new" "$packed" || return
    fi
    copy_apt_settings "$2" &&
        cp /etc/resolv.conf "$2/etc/resolv.conf" &&
        printf '127.0.0.1 localhost\n127.0.1.1 %s\n' "$(hostname)" >"$2/etc/hosts" &&
        mount -t proc proc "$2/proc" &&
        mount -t devpts -o newinstance,ptmxmode=666 devpts "$2/dev/pts" &&
        ln -sf pts/ptmx "$2/dev/ptmx" &&
        mount -t tmpfs -o mode=1777 shm "$2/dev/shm" &&
        chroot "$2" useradd --create-home --shell /bin/bash student &&
        chroot "$2" useradd --create-home --shell /bin/bash teacher &&
        clone "$2" student workspace && clone "$2" student "a folder" && clone "$2" teacher workspace &&
        drop_lists "$2"
}

clone() { # ROOT USER FOLDER
    local home=/home/$2
    git clone --quiet --no-hardlinks "$workspace" "$1$home/$3" &&
        git -C "$1$home/$3" checkout --quiet --detach "$commit" &&
        chroot "$1" chown -R "$2:" "$home/$3"
}

drop_lists() { find "$1/var/lib/apt/lists" -mindepth 1 -delete; } # ROOT

# Run in the clean system, with nothing of this machine's environment but a proxy. Offline
# means a network namespace that holds a loopback device and nothing else.
within() { # ROOT USER online|offline COMMAND…
    local root=$1 user=$2 name folder
    local -a environment into=()
    case $user in root) folder=/root ;; *) folder=/home/$user ;; esac
    environment=(HOME="$folder" USER="$user" LOGNAME="$user" TERM=dumb
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin)
    [ "$user" = root ] || folder=$folder/$place
    for name in http_proxy https_proxy no_proxy; do
        [ -z "${!name-}" ] || environment+=("$name=${!name}")
    done
    [ "$3" = online ] || into=(nsenter --net="$net")
    shift 3
    # shellcheck disable=SC2016
    exec "${into[@]}" env -i "${environment[@]}" chroot --userspec="$user:$user" "$root" \
        sh -c 'cd "$0" && exec "$@"' "$folder" "$@"
}
# In which folder of the user's home that is.
place=workspace

end_of_log() { tail -n 30 "$log" >&2; }

# Expect a command of a user's to end with 125 and a sentence with certain words, and soon.
refuses() { # WORDS ROOT USER online|offline COMMAND…
    local words=$1 status=0 began=$SECONDS
    shift
    (within "$@") >"$log" 2>&1 || status=$?
    [ "$status" = 125 ] && grep -q "^ci/.*$words" "$log" && [ $((SECONDS - began)) -lt "$limit_of_refusal" ] &&
        say "refused as it should be: $(grep "^ci/.*$words" "$log" | cut -c 1-150)" && return
    say "status $status after $((SECONDS - began)) s, expected was 125 with '$words' of: ${*:2}"
    end_of_log
    return 1
}

# A command that must be good.
succeeds() { # ROOT USER online|offline COMMAND…
    (within "$@") >"$log" 2>&1 && return
    say "failed: ${*:2}"
    end_of_log
    return 1
}

# Run as root what ci/exec or ci/test has just printed for people to copy; apt asks them once.
by_hand() { # ROOT
    local lines
    lines=$(grep -v '^ci/' "$log")
    say "as root: $(cut -c 1-150 <<<"$lines")"
    succeeds "$1" root online env DEBIAN_FRONTEND=noninteractive sh -ec "$lines" < <(yes)
}

install_sudo() { # ROOT
    [ ! -x "$1/usr/bin/sudo" ] || return 0
    succeeds "$1" root online sh -c \
        'apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends sudo' &&
        echo 'teacher ALL=(ALL:ALL) NOPASSWD: ALL' >"$1/etc/sudoers.d/teacher" &&
        drop_lists "$1"
}

take_refusals() { # SUITE ROOT
    place='a folder' refuses "stumble over the ' ' in" "$2" student online ./ci/exec true &&
        refuses "without sudo only root" "$2" student online ./ci/exec true &&
        install_sudo "$2" &&
        refuses "sudo did not let student install" "$2" student online ./ci/exec true &&
        refuses "no package can be downloaded" "$2" teacher offline ./ci/exec true &&
        verdict="each with its sentence"
}

take_by_hand() { # SUITE ROOT
    refuses "packages are missing" "$2" student online env CI_EXEC_NO_INSTALL=1 ./ci/exec true &&
        by_hand "$2" &&
        succeeds "$2" student offline ./ci/exec rospack find basic_comms &&
        verdict="what it printed was enough"
}

# From the first command until a second one hears the process node.
take_launch() { # SUITE ROOT
    local began seconds launch heard=no command
    command=$(readme_commands | head -n 1)
    install_sudo "$2" || return
    began=$SECONDS
    say "$1: what '$command' needs"
    succeeds "$2" teacher online ./ci/exec true || return
    say "$1: $command"
    # Nobody else's master is there to be heard.
    if (within "$2" teacher offline ./ci/exec rosnode list) >"$log" 2>&1; then
        verdict="there was a master before anything was launched"
        return 1
    fi
    (within "$2" teacher offline sh -c "exec $command" >"$log.launch" 2>&1) &
    launch=$!
    while [ $((SECONDS - began)) -lt "$limit" ] && kill -0 "$launch" 2>/dev/null; do
        sleep 1
        if (within "$2" teacher offline timeout "$limit" ./ci/exec rostopic echo -n 1 /proc_signal) >"$log" 2>&1; then
            heard=yes
            break
        fi
    done
    seconds=$((SECONDS - began))
    verdict="first sample after $seconds s"
    kill -INT "$launch" 2>/dev/null || :
    wait "$launch" || :
    if [ "$heard" = yes ] && [ "$seconds" -lt "$limit" ]; then return 0; fi
    verdict="no sample on /proc_signal within $limit s"
    tail -n 30 "$log.launch" "$log" >&2
    return 1
}

# Not as root, and without sudo.
take_test() { # SUITE ROOT
    local command
    command=$(readme_commands | tail -n 1)
    [ -z "$tiers" ] || command="$command ${tiers//,/ }"
    say "$1: what '$command' needs"
    refuses "packages are missing" "$2" student online sh -c "CI_EXEC_NO_INSTALL=1 exec $command" &&
        by_hand "$2" || return
    say "$1: $command"
    (within "$2" student offline sh -c "exec $command") 2>&1 | tee "$log" || {
        verdict="tests: $(tail -n 1 "$log")"
        return 1
    }
    verdict="tests: $(tail -n 1 "$log")"
}

# Take a part on a system of its own.
take() { # PART SUITE
    local root=$room/$2.$1 log=$room/$2.$1.log status=0
    say "$2: $1"
    net=$room/$2.$1.net
    : >"$net"
    unshare --net="$net" ip link set lo up && bootstrap "$2" "$root" || return
    verdict="see above"
    "take_$1" "$2" "$root" || status=1
    umount --lazy "$root/proc" "$root/dev/pts" "$root/dev/shm" "$net"
    rm -rf --one-file-system "$root"
    return "$status"
}

main() { # DIRECTORY PART,… TIER,… SUITE…
    local room=$1 parts=$2 tiers=$3 suite part verdict word commit mirror net status=0
    local -a summary
    shift 3
    commit=$(git -C "$workspace" rev-parse HEAD)
    find_mirror
    for suite; do
        for part in ${parts//,/ }; do
            verdict="no system to try it on"
            if take "$part" "$suite"; then word=ok; else word=FAILED status=1; fi
            summary+=("$(printf '%-6s %-9s %-9s %s' "$word" "$suite" "$part" "$verdict")")
        done
    done
    printf '%s\n' "${summary[@]}"
    exit "$status"
}

# A function, so that nothing of this file is still to be read while it runs. (Tests source it.)
[ "${BASH_SOURCE[0]}" != "$0" ] || main "$@"
