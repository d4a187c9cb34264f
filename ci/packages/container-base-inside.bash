#!/usr/bin/env bash
# Usage: container-base-inside.bash DIRECTORY SUITE
#
# The part of ci/container that runs in namespaces of its own: make DIRECTORY/base.tar.
set -euo pipefail
me=ci/container
source "$(dirname "${BASH_SOURCE[0]}")/../systems/clean-system.bash"

pack() { # SUITE ROOT
    rm -f "$2"/var/cache/apt/archives/*.deb
    tar -C "$2" --one-file-system -cf "$room/base.tar" .
}

room=$1
find_mirror
with_system "$2" base pack
