# Packages that a command needs: of the workspace, and their dependencies in apt's list.

# Set by choose_packages: all, names, or nothing. All by default.
asked_for=all

# ROS's own commands need the packages that one of their words names. Commands that inspect running
# nodes, such as rostopic, need no others.
choose_packages() { # [COMMAND [ARGUMENT…]]
    local word name
    case ${1-} in
        roslaunch | rosrun | rosbag | rosmsg | rosnode | rosparam | rosservice | rossrv | rostopic) ;;
        *) return 0 ;;
    esac
    asked_for=$(for word in "${@:2}"; do
        for name in ${word//[!a-zA-Z0-9_]/ }; do
            [ ! -f "$workspace/src/$name/package.xml" ] || echo "$name"
        done
        [ "$1" != roslaunch ] || packages_of_argument "$word"
    done)
    if [ -z "$asked_for" ] && [[ $1 == @(roslaunch|rosrun) ]]; then asked_for=all; fi
}

# An argument such as plot:=true starts an optional package, which its doc names.
packages_of_argument() { # WORD
    [[ $1 == *:=* ]] || return 0
    find "$workspace"/src/*/launch -name '*.launch' -exec cat {} + 2>/dev/null | tr '\n' ' ' |
        grep -oE "<arg name=\"${1%%:=*}\"[^>]* needs the package [a-z0-9_]+" | sed 's/.* //' || :
}

# The packages of the last build.
packages_before() { sed -n 's/^packages //p' "$stamp" 2>/dev/null || :; }

# The packages requested now or before, with the keys of all dependencies; or all.
needs() {
    local before
    before=$(packages_before)
    if [[ $asked_for == all || $before == all || -z $asked_for$before ]]; then
        echo all
    else
        # shellcheck disable=SC2086
        dependencies | closure $before $asked_for
    fi
}

# A line for each dependency in a package.xml, except those of tests: the package's folder, and the key.
dependencies() {
    awk -v RS='<' '
        FNR == 1 { parts = split(FILENAME, part, "/") }
        /^((build|buildtool|build_export|buildtool_export|exec|run)_)?depend[[:space:]>]/ {
            sub(/^[^>]*>/, "")
            print part[parts - 1], $1
        }
    ' "$workspace"/src/*/package.xml
}

# These names and all of their dependencies, by the lines of standard input.
closure() { # NAME…
    awk -v names="$*" '
        { keys[$1] = keys[$1] " " $2 }
        END {
            for (count = split(names, name); ++i <= count;) {
                if (name[i] in seen) continue
                seen[name[i]]
                print name[i]
                for (more = split(keys[name[i]], key); more; more--) name[++count] = key[more]
            }
        }
    ' | LC_ALL=C sort
}

# The packages of the workspace to build: all, or names in one line.
packages_to_build() {
    local name line=''
    for name in $(needs); do
        if [ "$name" = all ] || [ -f "$workspace/src/$name/package.xml" ]; then line="$line $name"; fi
    done
    echo "${line# }"
}

# Remove from Debian's packages on standard input those that packaging/dependencies.txt has only for
# packages and keys that are not needed. (Lines for folders, such as launch/, are for all packages.)
needed_of_apt() {
    local needed
    needed=$(needs)
    if [ "$needed" = all ]; then
        cat
    else
        awk '
            look == "needs" { needed[$1]; next }
            look == "table" {
                sub(/#.*/, "")
                key = $1
                sub(/:$/, "", key)
                for (i = 2; i <= NF; i++) {
                    if (key in needed || key ~ /\/$/) wanted[$i]; else other[$i]
                }
                next
            }
            $1 in wanted || !($1 in other)
        ' look=needs <(echo "$needed") look=table "$workspace/packaging/dependencies.txt" look= -
    fi
}
