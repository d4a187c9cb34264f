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
        !($1 in installed) { print $1 }
    ' look=up <(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${listed[@]}" 2>/dev/null || :) \
        look= <(printf '%s\n' "${listed[@]}")
}

# What apt could not install from the lists of packages that it has.
unknown_packages() { # PACKAGE…
    awk '
        look == "up" && /^[^ ]/ { name = $1; next }
        look == "up" { if ($1 == "Candidate:" && $2 != "(none)") known[name]; next }
        !($1 ":" in known) { print $1 }
    ' look=up <(LC_ALL=C apt-cache policy "$@" 2>/dev/null || :) look= <(printf '%s\n' "$@")
}

# Of packages that this release lacks, those to be borrowed from a later one: name, path in
# the archive and checksum.
borrowed_packages() { # PACKAGE…
    awk -v wanted=" $* " -v archive="$(archive_mirrors | head -n 1 | cut -d ' ' -f 1)" '
        /^\[/ { take = ($0 == "[borrowed " archive "]"); next }
        take && index(wanted, " " $1 " ") { print }
    ' "$workspace/ci/apt-packages.txt"
}

left_out() { # "NAME…" NAME…: the other names without those of the first argument
    local without=" $1 " name
    for name in "${@:2}"; do
        [[ $without == *" $name "* ]] || echo "$name"
    done
}

# The archives that apt uses, a line each: "LABEL URL".
archive_mirrors() {
    # shellcheck disable=SC2016
    apt-get indextargets --format '$(LABEL) $(REPO_URI)' 'Created-By: Packages' |
        awk '/^(Debian|Ubuntu) / && !seen[$0]++'
}

# Download a package from the first mirror that has it; apt's tool knows its proxies.
borrow() { # PATH CHECKSUM FILE
    local mirror
    while read -r _ mirror; do
        PATH=$PATH:/usr/lib/apt apt-helper download-file "$mirror$1" "$3" "SHA256:$2" && return
    done < <(archive_mirrors)
    return 1
}

system_name() {
    (
        PRETTY_NAME=
        # shellcheck source=/dev/null
        [ ! -r /etc/os-release ] || source /etc/os-release
        echo "${PRETTY_NAME:-this system}"
    )
}

as_root() { # COMMAND…
    set -- env LC_ALL=C DEBIAN_FRONTEND=noninteractive NEEDRESTART_SUSPEND=1 "$@"
    if [ "$EUID" = 0 ]; then "$@"; else sudo "$@"; fi
}

update_lists() {
    say "apt-get update: its lists of packages are missing or old."
    # Unlike dpkg's lock, apt has no option to wait for that of the lists.
    local give_up=$((SECONDS + 600))
    until as_root apt-get update >"$state/log" 2>&1; do
        if ! grep -q 'Could not get lock' "$state/log" || [ "$SECONDS" -gt "$give_up" ]; then
            cat "$state/log"
            die "apt-get update failed."
        fi
        sleep 2
    done
}

# For people to copy.
apt_line() { # PACKAGE…
    local sudo=''
    [ "$EUID" = 0 ] || ! command -v sudo >/dev/null || sudo='sudo '
    echo "${sudo}apt-get install --no-install-recommends $*"
}

by_hand() { # PACKAGE…
    local mirror package path
    while read -r package path _; do
        read -r _ mirror < <(archive_mirrors)
        say "apt knows no $package here; where the release has none, this one fits: $mirror$path"
    done < <(borrowed_packages "$(unknown_packages "$@" | xargs)")
    apt_line "$@"
}

install_packages() { # SECTION…
    local -a missing unknown borrowed install
    local package path checksum
    mapfile -t missing < <(missing_packages "$@")
    [ ${#missing[@]} -gt 0 ] || return 0

    if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
        # Who has built Noetic on another system knows what it needs there.
        if has_noetic; then return 0; fi
        die "$(system_name) is not served: ROS 1 is installed by apt on Debian 11 to 13 and" \
            "Ubuntu 22.04 and 24.04, or found in $noetic."
    fi
    if [ "${CI_EXEC_NO_INSTALL-}" = 1 ]; then
        say "packages are missing, and CI_EXEC_NO_INSTALL=1 forbids to install them. This does:"
        by_hand "${missing[@]}"
        exit 125
    fi
    if [ "$EUID" != 0 ] && ! command -v sudo >/dev/null; then
        say "packages are missing, and without sudo only root can install them. This does:"
        by_hand "${missing[@]}"
        exit 125
    fi

    say "installing packages: $(apt_line "${missing[@]}")"
    if compgen -G '/var/lib/dpkg/updates/[0-9]*' >/dev/null; then
        say "an earlier installation was cut short: letting dpkg finish it first."
        logged as_root dpkg --configure -a || die "dpkg --configure -a failed."
    fi
    mapfile -t unknown < <(unknown_packages "${missing[@]}")
    if [ ${#unknown[@]} -gt 0 ]; then
        update_lists
        mapfile -t unknown < <(unknown_packages "${missing[@]}")
        mapfile -t borrowed < <(borrowed_packages "${unknown[@]}")
        mapfile -t unknown < <(left_out "${borrowed[*]%% *}" "${unknown[@]}")
        [ ${#unknown[@]} = 0 ] ||
            die "$(system_name) has no package ${unknown[*]}: served are Debian 11 to 13, Ubuntu 22.04 and" \
                "24.04 (with universe), and systems with ROS in $noetic."
        mapfile -t missing < <(left_out "${borrowed[*]%% *}" "${missing[@]}")
        for package in "${borrowed[@]}"; do
            read -r package path checksum <<<"$package"
            say "$(system_name) has no $package: taking that of a later release, $path"
            logged borrow "$path" "$checksum" "$state/$package.deb" || die "cannot download $path."
            missing+=("$state/$package.deb")
        done
    fi
    install=(as_root apt-get install --yes --no-install-recommends
        -o DPkg::Lock::Timeout=600 "${missing[@]}")
    if ! "${install[@]}" >"$state/log" 2>&1; then
        # The lists may name versions that the mirror no longer holds.
        update_lists
        logged "${install[@]}" || die "apt-get install failed."
    fi
    mapfile -t missing < <(missing_packages "$@")
    [ ${#missing[@]} = 0 ] || die "apt-get has not installed ${missing[*]}."
}
