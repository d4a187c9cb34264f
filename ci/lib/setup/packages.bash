# System packages: what ci/apt-packages.txt lists, what is missing, how it comes in.

has_noetic() { [ -f "$noetic/setup.bash" ]; }

listed_packages() { # SECTION…
    awk -v wanted=" $* " -v noetic="$(! has_noetic || echo yes)" '
        { sub(/#.*/, "") }
        /^\[/ {
            gsub(/[][]/, "")
            take = index(wanted, " " $1 " ") && !(noetic && $2 == "ros")
            next
        }
        take && NF { print $1 }
    ' "$workspace/ci/apt-packages.txt"
}

missing_packages() { # SECTION…
    local -a listed
    mapfile -t listed < <(listed_packages "$@")
    # Without dpkg there is no telling: everything counts as missing.
    awk '
        look == "up" { if ($1 == "installed") installed[$2]; next }
        NF && !($1 in installed) { print $1 }
    ' look=up <(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${listed[@]}" 2>/dev/null || :) \
        look= <(printf '%s\n' "${listed[@]}")
}

# What apt could not install from the lists of packages that it has.
unknown_packages() { # PACKAGE…
    awk '
        look == "up" && /^[^ ]/ { name = $1; next }
        look == "up" { if ($1 == "Candidate:" && $2 != "(none)") known[name]; next }
        NF && !($1 ":" in known) { print $1 }
    ' look=up <(LC_ALL=C apt-cache policy "$@" 2>/dev/null || :) look= <(printf '%s\n' "$@")
}

# Of some packages, those that this release lacks, to be borrowed from a later one: name, path
# in the archive and checksum. It does not take apt's lists to know them.
borrowed_packages() { # PACKAGE…
    awk -v wanted=" $* " -v release="$(of_release VERSION_CODENAME)" '
        { sub(/#.*/, "") }
        /^\[/ { take = ($0 == "[borrowed " release "]"); next }
        take && NF && index(wanted, " " $1 " ") { print }
    ' "$workspace/ci/apt-packages.txt"
}

left_out() { # "NAME…" NAME…: the other names without those of the first argument
    local without=" $1 " name
    for name in "${@:2}"; do
        [[ $without == *" $name "* ]] || echo "$name"
    done
}

# The first thing that apt fetches from each archive; it tells without any lists.
archive_uris() {
    apt-get update --print-uris 2>/dev/null | sed -n "s|^'\(.*/InRelease\)' .*|\1|p"
}

# The archives that apt uses, a line each.
archive_mirrors() { archive_uris | sed -n 's|/dists/.*|/|p' | awk '!seen[$0]++'; }

# Download a package from the first mirror that has it; apt's tool knows its proxies.
borrow() { # PATH CHECKSUM FILE
    local mirror
    while read -r mirror; do
        PATH=$PATH:/usr/lib/apt apt-helper download-file "$mirror$1" "$3" "SHA256:$2" && return
    done < <(archive_mirrors)
    return 1
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
    # sudo takes them away, and apt then asks the archives directly.
    for name in http_proxy https_proxy no_proxy; do
        [ -z "${!name-}" ] || set -- "$name=${!name}" "$@"
    done
    set -- env LC_ALL=C DEBIAN_FRONTEND=noninteractive "$@"
    # Without the lock of set_up, which a service that a package starts would keep.
    if is_root; then "$@" 9>&-; else sudo "$@" 9>&-; fi
}

# apt would try each package for minutes where no archive can be reached; so one small file is
# asked for first, and no more is waited than this, s.
patience=40

refuse_without_network() { # PACKAGE…
    local uri give_up=$((SECONDS + patience))
    local -a uris
    : >"$state/log"
    mapfile -t uris < <(archive_uris)
    for uri in "${uris[@]}"; do
        [[ $uri == http* ]] || return 0 # on a disk
    done
    # What apt has downloaded already needs no network.
    if [ -z "$(unknown_packages "$@")" ] && uri=$(apt-get install --print-uris -qq --yes \
        --no-install-recommends "$@" 2>/dev/null) && [ -z "$uri" ]; then
        return 0
    fi
    for uri in "${uris[@]}"; do
        [ "$SECONDS" -lt "$give_up" ] || break
        if PATH=$PATH:/usr/lib/apt timeout $((give_up - SECONDS)) apt-helper -o Acquire::Retries=0 \
            -o Acquire::http::Timeout=15 -o Acquire::https::Timeout=15 \
            download-file "$uri" "$state/InRelease" >>"$state/log" 2>&1; then
            rm -f "$state/InRelease"
            return 0
        fi
    done
    # An archive without such a file is there, too; and root may read more of apt's settings.
    if [ ${#uris[@]} = 0 ] || grep -qE '404 +Not Found|Unable to read' "$state/log"; then
        return 0
    fi
    uri=$(sed -n 's/^E: Failed to fetch [^ ]* *//p' "$state/log" | head -n 1)
    die "no package can be downloaded (${uris[0]}: ${uri:-no answer within $patience s}):" \
        "check the network, or the proxy that apt is told to use, and try again."
}

# The end of what apt wrote: without a network that is a thousand lines.
end_of_log() { tail -n 20 "$state/log"; }

update_lists() {
    say "apt-get update: its lists of packages are missing or old."
    # Unlike dpkg's lock, apt has no option to wait for that of the lists.
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

# For people to copy as it stands; so it works with missing lists as well.
by_hand() { # PREFIX PACKAGE…
    local prefix=$1 package path checksum mirror
    local -a borrowed install
    shift
    mapfile -t borrowed < <(borrowed_packages "$@")
    mapfile -t install < <(left_out "${borrowed[*]%% *}" "$@")
    echo "${prefix}apt-get update"
    # Not below build/, where root would leave what the user cannot change.
    # shellcheck disable=SC2016
    [ ${#borrowed[@]} = 0 ] || echo 'debs=$(mktemp -d)'
    for package in "${borrowed[@]}"; do
        read -r package path checksum <<<"$package"
        read -r mirror < <(archive_mirrors) || :
        echo "/usr/lib/apt/apt-helper download-file $mirror$path \"\$debs/$package.deb\" SHA256:$checksum"
        install+=("\"\$debs/$package.deb\"")
    done
    echo "$prefix$(apt_line "${install[@]}")"
}

refuse_to_install() { # WHY PREFIX PACKAGE…
    say "$1"
    by_hand "${@:2}"
    exit 125
}

install_packages() { # SECTION…
    local -a missing unknown borrowed install
    local package path checksum sudo=''
    mapfile -t missing < <(missing_packages "$@")
    [ ${#missing[@]} -gt 0 ] || return 0

    if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
        # Who has built Noetic on another system knows what it needs there.
        if has_noetic; then return 0; fi
        die "$(system_name) is not served: ROS 1 is installed by apt on Debian 11, 12 and 13;" \
            "elsewhere the ROS in $noetic is taken if there is one, which is untested."
    fi
    is_root || ! command -v sudo >/dev/null || sudo='sudo '
    if [ "${CI_EXEC_NO_INSTALL-}" = 1 ]; then
        refuse_to_install "packages are missing, and CI_EXEC_NO_INSTALL=1 forbids to install them. This does:" \
            "$sudo" "${missing[@]}"
    fi
    if ! is_root && [ -z "$sudo" ]; then
        refuse_to_install "packages are missing, and without sudo only root can install them. This does:" \
            "" "${missing[@]}"
    fi

    say "installing packages: $sudo$(apt_line "${missing[@]}")"
    refuse_without_network "${missing[@]}"
    mapfile -t borrowed < <(borrowed_packages "${missing[@]}")
    mapfile -t missing < <(left_out "${borrowed[*]%% *}" "${missing[@]}")
    # Once and before all else: sudo says why it refuses, and apt is not to blame.
    as_root true || refuse_to_install \
        "sudo did not let $(user_name) install packages (see above). An administrator can, as root:" \
        "" "${missing[@]}" "${borrowed[@]%% *}"
    if compgen -G '/var/lib/dpkg/updates/[0-9]*' >/dev/null; then
        say "an earlier installation was cut short: letting dpkg finish it first."
        logged as_root dpkg --configure -a || die "dpkg --configure -a failed."
    fi
    mapfile -t unknown < <(unknown_packages "${missing[@]}")
    if [ ${#unknown[@]} -gt 0 ]; then
        update_lists
        mapfile -t unknown < <(unknown_packages "${missing[@]}")
        if [ ${#unknown[@]} -gt 0 ] && grep -qE '^(W|E|Err)\b' "$state/log"; then
            end_of_log
            die "apt-get update did not get all lists of packages, and those it has do not name ${unknown[*]}."
        fi
        [ ${#unknown[@]} = 0 ] ||
            die "$(system_name) has no package ${unknown[*]}: served are Debian 11, 12 and 13; elsewhere the" \
                "ROS in $noetic is taken if there is one, which is untested."
    fi
    for package in "${borrowed[@]}"; do
        read -r package path checksum <<<"$package"
        say "$(system_name) has no $package: taking that of a later release, $path"
        logged borrow "$path" "$checksum" "$state/$package.deb" || die "cannot download $path."
        missing+=("$state/$package.deb")
    done
    install=(as_root apt-get install --yes --no-install-recommends
        -o DPkg::Lock::Timeout=600 -o Acquire::Retries=1 "${missing[@]}")
    if ! quietly "${install[@]}"; then
        # The lists may name versions that the mirror no longer holds.
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
