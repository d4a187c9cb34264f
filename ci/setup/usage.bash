# The help of a command is its leading comment.

# Set by a command with --only: the module of ci that prints the names, and its arguments.
choices=()

usage() {
    sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p}' "$0"
    [ -z "${choices[*]-}" ] || python3 "$(dirname "${BASH_SOURCE[0]}")/.." "${choices[@]}"
}

# Show it and exit, if requested.
help_if_asked() { # [ARGUMENT…]
    [[ ${1-} == @(-h|--help) ]] || return 0
    usage
    exit
}

# The same, with status 125 if the argument is unknown.
help_or_refuse() { # ARGUMENT
    help_if_asked "$1"
    usage
    exit 125
}
