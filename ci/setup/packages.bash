# System packages: the list ci/apt-packages.txt, missing packages, installation.

listed_packages() { # SECTION…
    awk -v wanted=" $* " -v ros="$ros" '
        { sub(/#.*/, "") }
        /^\[/ {
            gsub(/[][]/, "")
            take = index(wanted, " " $1 " ") && !(ros && $2 == "ros")
            next
        }
        take && NF { print $1 }
    ' "$workspace/ci/apt-packages.txt"
}

# The arguments that are not a line of standard input.
not_listed() { # NAME…
    grep -vxF -e '' -f - <(printf '%s\n' "$@") || :
}

missing_packages() { # SECTION…
    local -a listed
    mapfile -t listed < <(listed_packages "$@" | needed_of_apt)
    # Without dpkg, everything counts as missing.
    { dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${listed[@]}" 2>/dev/null || :; } |
        sed -n 's/^installed //p' | not_listed "${listed[@]}"
}

# The packages that apt's lists do not have.
unknown_packages() { # PACKAGE…
    { LC_ALL=C apt-cache policy "$@" 2>/dev/null || :; } | awk '
        /^[^ ]/ { name = $1; sub(/:$/, "", name) }
        $1 == "Candidate:" && $2 != "(none)" { print name }
    ' | not_listed "$@"
}

# The first file that apt fetches from each archive, which needs no lists.
archive_uris() {
    apt-get update --print-uris 2>/dev/null | sed -n "s|^'\(.*/InRelease\)' .*|\1|p"
}

of_release() ( # NAME: of a field of /etc/os-release
    # shellcheck source=/dev/null
    [ ! -r "$os_release" ] || source "$os_release"
    echo "${!1-}"
)

system_name() {
    local name
    name=$(of_release PRETTY_NAME)
    echo "${name:-this system}"
}

is_root() { [ "$(id -u)" = 0 ]; }

as_root() { # COMMAND…
    local name
    set -- NEEDRESTART_SUSPEND=1 "$@"
    # sudo removes them, and apt would then connect to the archives directly.
    for name in http_proxy https_proxy no_proxy; do
        [ -z "${!name-}" ] || set -- "$name=${!name}" "$@"
    done
    set -- env LC_ALL=C DEBIAN_FRONTEND=noninteractive "$@"
    # Without the lock of set_up, which a service started by a package would keep.
    if is_root; then "$@" 9>&-; else sudo "$@" 9>&-; fi
}

# Without a reachable archive apt would try each package for minutes; so one small file is
# requested first, with this timeout [s].
patience=40

refuse_without_network() { # PACKAGE…
    local uri left give_up=$((SECONDS + patience))
    local -a uris
    : >"$state/log"
    mapfile -t uris < <(archive_uris)
    for uri in "${uris[@]}"; do
        [[ $uri == http* ]] || return 0 # on a disk
    done
    # Downloaded packages need no network.
    if [ -z "$(unknown_packages "$@")" ] && uri=$(apt-get install --print-uris -qq --yes \
        --no-install-recommends "$@" 2>/dev/null) && [ -z "$uri" ]; then
        return 0
    fi
    for uri in "${uris[@]}"; do
        left=$((give_up - SECONDS)) # computed once: timeout takes 0 as no limit
        [ "$left" -gt 0 ] || break
        if PATH=$PATH:/usr/lib/apt timeout "$left" apt-helper -o Acquire::Retries=0 \
            -o Acquire::http::Timeout=15 -o Acquire::https::Timeout=15 \
            download-file "$uri" "$state/InRelease" >>"$state/log" 2>&1; then
            rm -f "$state/InRelease"
            return 0
        fi
    done
    # An archive without such a file is reachable, too; and root may read more of apt's settings.
    if [ ${#uris[@]} = 0 ] || grep -qE '404 +Not Found|Unable to read' "$state/log"; then
        return 0
    fi
    uri=$(sed -n '/^E: Failed to fetch [^ ]* */{s///p;q}' "$state/log")
    die "no package can be downloaded (${uris[0]}: ${uri:-no answer within $patience s}):" \
        "check the network, or the proxy that apt is configured to use, and try again."
}

# The end of apt's output: without a network that is a thousand lines.
end_of_log() { tail -n 20 "$state/log"; }

update_lists() {
    say "apt-get update: its package lists are missing or out of date."
    # apt can wait for dpkg's lock, but not for the lock of the lists.
    local give_up=$((SECONDS + 600))
    until quietly as_root apt-get update -o Acquire::Retries=1; do
        if ! grep -q 'Could not get lock' "$state/log" || [ "$SECONDS" -gt "$give_up" ]; then
            end_of_log
            die "apt-get update failed."
        fi
        sleep 2
    done
}

apt_line() { # PACKAGE…
    echo "apt-get install --no-install-recommends $*"
}

# For users to copy; so it works with missing lists as well.
by_hand() { # PREFIX PACKAGE…
    echo "${1}apt-get update"
    echo "$1$(apt_line "${@:2}")"
}

refuse_to_install() { # WHY PREFIX PACKAGE…
    say "$1"
    by_hand "${@:2}"
    exit 125
}

install_packages() { # SECTION…
    local -a missing unknown install
    local sudo=''
    mapfile -t missing < <(missing_packages "$@")
    [ ${#missing[@]} -gt 0 ] || return 0

    if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
        [ -n "$ros" ] || die "$(system_name) is not supported: ROS 1 is installed by apt on Debian 12, 13 and 14;" \
            "elsewhere source the setup.bash of a ROS 1 first, or have one in $opt_ros."
        build_is_fresh || say "without apt nothing is installed here. What the workspace needs besides ROS" \
            "('rosdep install --from-paths src' knows the names of other systems): ${missing[*]}"
        return 0
    fi
    is_root || ! command -v sudo >/dev/null || sudo='sudo '
    if [ "${CI_EXEC_NO_INSTALL-}" = 1 ]; then
        refuse_to_install "packages are missing, and CI_EXEC_NO_INSTALL=1 forbids installing them. To install them:" \
            "$sudo" "${missing[@]}"
    fi
    if ! is_root && [ -z "$sudo" ]; then
        refuse_to_install "packages are missing, and without sudo only root can install them. To install them:" \
            "" "${missing[@]}"
    fi

    say "installing packages: $sudo$(apt_line "${missing[@]}")"
    refuse_without_network "${missing[@]}"
    # Once and first: sudo reports its own error, which is not apt's.
    as_root true || refuse_to_install \
        "sudo did not let $(user_name) install packages (see above). An administrator can, as root:" \
        "" "${missing[@]}"
    if compgen -G '/var/lib/dpkg/updates/[0-9]*' >/dev/null; then
        say "an earlier installation was interrupted: letting dpkg finish it first."
        logged as_root dpkg --configure -a || die "dpkg --configure -a failed."
    fi
    mapfile -t unknown < <(unknown_packages "${missing[@]}")
    if [ ${#unknown[@]} -gt 0 ]; then
        update_lists
        mapfile -t unknown < <(unknown_packages "${missing[@]}")
        if [ ${#unknown[@]} -gt 0 ] && grep -qE '^(W|E|Err)\b' "$state/log"; then
            end_of_log
            die "apt-get update could not fetch all package lists, and those it has do not contain ${unknown[*]}."
        fi
        [ ${#unknown[@]} = 0 ] ||
            die "$(system_name) has no package ${unknown[*]}. ROS 1 is installed by apt on Debian 12, 13 and 14;" \
                "elsewhere source the setup.bash of a ROS 1 first, or have one in $opt_ros."
    fi
    install=(as_root apt-get install --yes --no-install-recommends
        -o DPkg::Lock::Timeout=600 -o Acquire::Retries=1 "${missing[@]}")
    if ! quietly "${install[@]}"; then
        # The lists may name versions that the mirror no longer has.
        refuse_without_network "${missing[@]}"
        update_lists
        quietly "${install[@]}" || {
            end_of_log
            die "apt-get install failed."
        }
    fi
    mapfile -t missing < <(missing_packages "$@")
    [ ${#missing[@]} = 0 ] || die "apt-get has not installed ${missing[*]}."
}
