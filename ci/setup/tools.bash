# Programs for developers that Debian does not have, from PyPI, each in an environment of its own.

# Make build/NAME hold what is required, unless it does already.
fetch_tool() { # NAME REQUIREMENT
    local place=$workspace/build/$1
    [ "$(cat "$place/made" 2>/dev/null)" != "$2" ] || return 0
    say "fetching $2 from PyPI"
    rm -rf "$place"
    quietly python3 -m venv "$place" ||
        die "cannot create a virtual environment: $(tail -n 1 "$state/log")"
    # shellcheck disable=SC2086
    quietly "$place/bin/pip" install --quiet --retries 1 $2 ||
        die "$2 could not be installed from PyPI: $(tail -n 1 "$state/log")"
    echo "$2" >"$place/made"
}
