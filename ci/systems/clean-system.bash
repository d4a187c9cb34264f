# Shared by the parts of ci/clean-room and ci/deb that run in namespaces: a minimal Debian, and
# commands in it. The caller has set me, its name, and room, a directory.

workspace=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)
source "$workspace/ci/systems/pages.bash"

say() { printf '%s: %s\n' "$me" "$*" >&2; }

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

# The clean system needs this machine's settings to reach the mirror.
copy_apt_settings() { # ROOT
    apt-config dump | grep -E '^Acquire::(https?::|Check-|Retries)' >"$1/etc/apt/apt.conf.d/90clean-room" || :
    local file
    sed -n 's/.*:CaInfo "\(.*\)";/\1/p' "$1/etc/apt/apt.conf.d/90clean-room" | while read -r file; do
        install -D -m 644 "$file" "$1/$file"
    done
}

# The same for PyPI, which only online commands reach. Debian's own certificates are generated again
# in there, so these have a separate file.
copy_pip_settings() { # ROOT
    local file
    file=$(sed -n 's/^ *cert *= *//p' /etc/pip.conf 2>/dev/null) || return 0
    [ -f "$file" ] || return 0
    install -m 644 "$file" "$1/etc/pip-certificates.crt"
    printf '[global]\ncert = /etc/pip-certificates.crt\n' >"$1/etc/pip.conf"
}

# Without users, and without apt's lists.
bootstrap() { # SUITE ROOT
    local packed=${CLEAN_ROOM_CACHE:-$room}/$1.tar new
    mkdir "$2" || return
    if [ -f "$packed" ]; then
        tar -C "$2" -xf "$packed" || return
    else
        say "$1: debootstrap from $mirror"
        # One script for all suites: debootstrap lacks a script for suites that are newer than itself.
        debootstrap --variant=minbase "$1" "$2" "$mirror" sid >"$log" 2>&1 || {
            end_of_log
            return 1
        }
        # Another run may be packing the same system.
        new=$(mktemp "$packed.XXXXXX") || return
        if ! { tar -C "$2" -cf "$new" . && mv "$new" "$packed"; }; then
            rm -f "$new"
            return 1
        fi
    fi
    copy_apt_settings "$2" &&
        copy_pip_settings "$2" &&
        cp /etc/resolv.conf "$2/etc/resolv.conf" &&
        printf '127.0.0.1 localhost\n127.0.1.1 %s\n' "$(hostname)" >"$2/etc/hosts" &&
        mount -t proc proc "$2/proc" &&
        mount -t devpts -o newinstance,ptmxmode=666 devpts "$2/dev/pts" &&
        ln -sf pts/ptmx "$2/dev/ptmx" &&
        mount -t tmpfs -o mode=1777 shm "$2/dev/shm" &&
        drop_lists "$2"
}

drop_lists() { find "$1/var/lib/apt/lists" -mindepth 1 -delete; } # ROOT

# Run in the clean system, with only a proxy from this machine's environment. Offline means a
# network namespace with only a loopback device.
within() { # ROOT USER online|offline COMMAND…
    local root=$1 user=$2 name folder
    local -a environment into=()
    case $user in root) folder=/root ;; *) folder=/home/$user ;; esac
    environment=(HOME="$folder" USER="$user" LOGNAME="$user" TERM=dumb
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin)
    [ "$user" = root ] || folder=$folder/${place-}
    for name in http_proxy https_proxy no_proxy; do
        [ -z "${!name-}" ] || environment+=("$name=${!name}")
    done
    [ "$3" = online ] || into=(nsenter --net="$net")
    shift 3
    # shellcheck disable=SC2016
    exec "${into[@]}" env -i "${environment[@]}" chroot --userspec="$user:$user" "$root" \
        sh -c 'cd "$0" && exec "$@"' "$folder" "$@"
}

end_of_log() { tail -n 30 "$log" >&2; }

# A command that must succeed.
succeeds() { # ROOT USER online|offline COMMAND…
    (within "$@") >"$log" 2>&1 && return
    say "failed: ${*:2}"
    end_of_log
    return 1
}

# Call a function on a separate system, which is removed afterwards.
with_system() { # SUITE NAME FUNCTION: it gets SUITE ROOT
    local root=$room/$1.$2 log=$room/$1.$2.log net=$room/$1.$2.net status=0
    : >"$net"
    unshare --net="$net" ip link set lo up && bootstrap "$1" "$root" || return
    "$3" "$1" "$root" || status=1
    umount --lazy "$root/proc" "$root/dev/pts" "$root/dev/shm" "$net"
    rm -rf --one-file-system "$root"
    return "$status"
}

# Take parts, each on a separate system, and end with a line for each of them.
take_parts() { # PART,… SUITE…: calls take_PART, which gets SUITE ROOT and may set verdict
    local parts=$1 suite part verdict word status=0
    local -a summary
    shift
    find_mirror
    for suite; do
        for part in ${parts//,/ }; do
            verdict="see above"
            say "$suite: $part"
            if with_system "$suite" "$part" "take_$part"; then word=ok; else word=FAILED status=1; fi
            summary+=("$(printf '%-6s %-9s %-9s %s' "$word" "$suite" "$part" "$verdict")")
        done
    done
    printf '%s\n' "${summary[@]}"
    exit "$status"
}
