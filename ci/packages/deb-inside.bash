#!/usr/bin/env bash
# Usage: deb-inside.bash DIRECTORY PART,… SUITE…
#
# The part of ci/deb, and of ci/container, that runs in namespaces.
set -euo pipefail
me=ci/deb
source "$(dirname "${BASH_SOURCE[0]}")/../systems/clean-system.bash"

# An ordinary user, apt's lists, and only required packages.
furnish() { # ROOT
    chroot "$1" useradd --create-home --shell /bin/bash student &&
        echo 'APT::Install-Recommends "false";' >"$1/etc/apt/apt.conf.d/91needed" &&
        succeeds "$1" root online apt-get update
}

apt_get() { # ROOT online|offline WHAT…
    succeeds "$1" root "$2" env DEBIAN_FRONTEND=noninteractive apt-get --yes "${@:3}"
}

# Type the command of the page in a directory with packages.
install_as_written() { # ROOT DIRECTORY
    local command
    command=$(page_commands docs/packaging.md Install | head -n 1)
    succeeds "$1" root offline env DEBIAN_FRONTEND=noninteractive \
        sh -ec "cd $2; ${command#sudo }" < <(yes)
}

# The system itself, for the container.
take_base() { # SUITE ROOT
    rm -f "$2"/var/cache/apt/archives/*.deb
    tar -C "$2" --one-file-system -cf "$room/base.tar" . && verdict="packed"
}

take_build() { # SUITE ROOT
    local tree=$2/home/student/tree date snapshot version
    snapshot=$(git -C "$workspace" log -1 --format=%cd.%h --date=format:%Y%m%d --abbrev=7 "$commit")
    date=$(git -C "$workspace" log -1 --format=%cD "$commit")
    furnish "$2" && mkdir "$2/home/student/earlier" "$tree" || return
    git -C "$workspace" archive "$commit" | tar -C "$tree" -x &&
        python3 "$workspace/ci" packages.debian_files "$tree" "$1" "$date" "$snapshot" &&
        chroot "$2" chown -R student: /home/student || return
    say "$1: what the build needs"
    apt_get "$2" online install build-essential lintian &&
        apt_get "$2" online build-dep /home/student/tree || return
    place=tree
    say "$1: dpkg-buildpackage"
    succeeds "$2" student offline dpkg-buildpackage -us -uc -b &&
        succeeds "$2" student offline sh -c \
            'lintian --fail-on error,warning --tag-display-limit 0 ../*.changes' || return
    # The same files again, as an earlier version, for the proof.
    version=$(within "$2" student offline dpkg-parsechangelog --show-field Version)
    # shellcheck disable=SC2016
    succeeds "$2" student offline env DEB_RULES_REQUIRES_ROOT=no sh -ec 'dh_gencontrol -- "-v$0~earlier"
        dh_md5sums
        dh_builddeb --destdir=../earlier' "$version" || return
    rm -rf "${dist:?}/$1"
    mkdir -p "$dist/$1/earlier" &&
        cp "$2"/home/student/*.{deb,buildinfo,changes} "$dist/$1" &&
        cp "$2"/home/student/earlier/*.deb "$dist/$1/earlier" || return
    verdict="$(within "$2" root offline sh -c 'ls /home/student/*.deb | wc -l') packages, version $version"
}

# The packages that some packages name in a field, without each other.
foreign() { # FIELD FILE…
    local file
    for file in "${@:2}"; do
        dpkg-deb --field "$file" "$1" | tr , '\n' | sed 's/^ *//' | grep -v '(= ' || :
    done | grep . | sort -u | paste --serial --delimiters=,
}

# Every file of a system except records of apt and programs.
every_file() { # ROOT
    find "$1" -xdev \( -path "$1/home" -o -path "$1/tmp" -o -path "$1/debs" -o -path "$1/var/cache" \
        -o -path "$1/var/log" \) -prune -o -print | sort
}

# Run the course from the installed packages, as an ordinary user.
runs() { # ROOT WHAT [PART]
    say "$2"
    place='' succeeds "$1" student offline python3 /debs/ci packages.deb_proof "${@:3}" || return
    sed 's/^/    /' "$log" >&2
}

# Copy these files into the system, and the program that tests the installation.
take_proof_along() { # ROOT FILE…
    mkdir -p "$1/debs/ci/packages" && cp -r "${@:2}" "$1/debs" &&
        cp "$workspace"/ci/__{init,main}__.py "$1/debs/ci" &&
        cp "$workspace"/ci/packages/{__init__,deb_proof,proof}.py "$1/debs/ci/packages"
}

# By the page's commands, with a network.
take_bridge() { # SUITE ROOT
    local -a command commands
    built_before "$1" && furnish "$2" && take_proof_along "$2" "$dist/$1"/*.deb || return
    mapfile -t commands < <(page_commands docs/packaging.md "The bridge to ROS 2")
    say "$1: what the bridge needs"
    read -ra command <<<"${commands[0]#sudo apt }"
    apt_get "$2" online "${command[@]}" &&
        succeeds "$2" root online env DEBIAN_FRONTEND=noninteractive sh -ec 'cd /debs
            apt-get --yes install python3-rostopic rosbash ./ros-ros2-bridge_*.deb \
                ./ros-basic-comms_*.deb ./ros-lifecycle-msgs_*.deb ./ros-nodekit*.deb' || return
    say "$1: ${commands[1]}"
    read -ra command <<<"${commands[1]}"
    place='' succeeds "$2" student online "${command[@]}" || return
    runs "$2" "$1: the bridge" bridge && verdict="received in ROS 2"
}

built_before() { # SUITE
    [ -d "$dist/$1/earlier" ] && return
    verdict="there are no packages in $dist/$1: build them first"
    return 1
}

take_prove() { # SUITE ROOT
    local files=("$dist/$1"/*.deb)
    local -a names
    built_before "$1" || return
    mapfile -t names < <(printf '%s\n' "${files[@]##*/}" | sed 's/_.*//')
    furnish "$2" && take_proof_along "$2" "${files[@]}" "$dist/$1/earlier" || return
    say "$1: what the packages depend on, recommend and suggest"
    apt_get "$2" online satisfy "$(foreign Depends "${files[@]}"), python3-rostopic, rosbash" &&
        apt_get "$2" online satisfy --simulate \
            "$(foreign Recommends "${files[@]}"), $(foreign Suggests "${files[@]}")" || return
    every_file "$2" >"$log.before"
    install_as_written "$2" /debs/earlier && runs "$2" "$1: an earlier version" &&
        install_as_written "$2" /debs && runs "$2" "$1: upgraded" &&
        apt_get "$2" offline purge "${names[@]}" || return
    every_file "$2" >"$log.after"
    diff "$log.before" "$log.after" >&2 || {
        verdict="files were left behind: see above"
        return 1
    }
    verdict="installed, run, upgraded, run, removed"
}

main() { # DIRECTORY PART,… SUITE…
    local room=$1 parts=$2 dist=$workspace/dist commit mirror place
    shift 2
    commit=$(git -C "$workspace" rev-parse HEAD)
    take_parts "$parts" "$@"
}

# A function, so that bash has read the whole file before it runs. (Tests source it.)
[ "${BASH_SOURCE[0]}" != "$0" ] || main "$@"
