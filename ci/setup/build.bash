# The build with catkin_make, only if its inputs or products have changed.

# A stamp is written after a good build and describes it line by line: the system
# it was made for, each file it read (Python sources run from where they are and
# need no build, unlike the files that list them) and each file it made.
stamp=$state/stamp
# Exists while a build runs, and remains if the build is interrupted.
building=$state/building

build_facts() {
    echo "workspace $workspace"
    echo "python $(readlink -f "$python")"
    echo "ros ${ros:-/usr}"
    echo "tests $(has_rostest && echo ON || echo OFF)"
    echo "without $(languages_left_out)"
    echo "packages $(packages_to_build)"
}

# Without C++ and Lisp a build from scratch takes a sixth less. By default, the languages of the last
# build are kept.
languages_left_out() {
    local kept
    kept=$(grep -s '^without ' "$stamp") || kept="without gencpp:geneus:genlisp:gennodejs"
    echo "${ROS_LANG_DISABLE-${kept#without }}"
}

build_inputs() {
    find -L "$workspace/src" -mindepth 2 \( -name '.*' -o -name __pycache__ \) -prune -o \
        -type f \( -name package.xml -o -name CMakeLists.txt -o -name setup.py -o -name '*.in' \
        -o -name '*.cmake' -o -name '*.msg' -o -name '*.srv' -o -name '*.action' -o -name '*.cfg' \
        -o -name '*.c' -o -name '*.cc' -o -name '*.cpp' -o -name '*.h' -o -name '*.hpp' \) \
        -printf 'in %P\t%s %T@\n' -o \
        -type f -path '*/scripts/*' -printf 'in %P\t\n' 2>/dev/null | LC_ALL=C sort
}

build_products() {
    find "$workspace/devel" \( -name __pycache__ -o -name '*.lock' \) -prune -o -type f \
        -printf 'out %P\n' 2>/dev/null | LC_ALL=C sort
}

# rostest's CMake file is installed with the tests' packages; without it no test can be configured.
has_rostest() {
    compgen -G "${ros:-/usr}/lib/*/cmake/rostest/rostestConfig.cmake" >/dev/null ||
        [ -e "${ros:-/usr}/share/rostest/cmake/rostestConfig.cmake" ]
}

build_is_fresh() {
    [ -f "$stamp" ] && [ ! -e "$building" ] && [ -f "$workspace/devel/setup.bash" ] &&
        [ "$(build_facts; build_inputs; build_products)" = "$(<"$stamp")" ]
}

# An existing build cannot be continued if it was interrupted, if it was made
# for another place or system (CMake keeps paths), or if a file it read is gone
# (catkin_make leaves the products of a removed package or message in place).
build_must_start_over() { # STAMP-TO-BE
    local cache=$workspace/build/CMakeCache.txt
    if [ -e "$building" ]; then return 0; fi
    if [ -f "$cache" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$workspace/src" "$cache"; then
        return 0
    fi
    [ -f "$stamp" ] && [ -n "$(awk -F '\t' '
        look == "up" { now[$1]; next }
        /^(workspace|python|ros|in) / && !($1 in now)
    ' look=up <(echo "$1") look= "$stamp")" ]
}

refuse_catkin_tools() {
    if grep -qs 'catkin build' "$workspace/build/.built_by"; then
        die "this tree was built with 'catkin build', and catkin refuses to mix that with catkin_make:" \
            "run 'catkin clean' first, or use another clone."
    fi
}

build() {
    local read_by_it packages
    packages=$(packages_to_build)
    if [ "$packages" = all ]; then packages=; fi
    read_by_it=$(build_facts; build_inputs)
    refuse_catkin_tools
    refuse_old_python
    tell_ros
    if build_must_start_over "$read_by_it"; then
        say "building from scratch with catkin_make${packages:+: $packages}"
        # The environment of ci/ros2 checks itself whether it is outdated; the results and copies of
        # ci/mutants are independent of this build. Its tool and the benchmark's peers hold paths: remove them.
        find "$workspace/build" -mindepth 1 -maxdepth 1 \
            ! \( -path "$state" -o -name 'ros2*' -o -name 'mutants*' -o -name 'test-times*' -o -name mypy \) -exec rm -rf {} +
        rm -rf "$workspace/devel"
    else
        say "building with catkin_make${packages:+: $packages}"
    fi
    : >"$building"
    # In a subshell, without other workspaces that the caller has sourced.
    if ! ROS_LANG_DISABLE=$(languages_left_out) \
        logged run_catkin_make "$(has_rostest && echo ON || echo OFF)" "${packages// /;}"; then
        [ ! -f "$stamp" ] || echo failed >>"$stamp"
        rm "$building"
        die "the build failed: see above."
    fi
    { echo "$read_by_it"; build_products; } >"$stamp.new"
    mv "$stamp.new" "$stamp"
    rm "$building"
}

run_catkin_make() ( # ON|OFF PACKAGE;…: with or without the tests' targets; all packages if none is named
    unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH
    [ -z "$ros" ] || source_setup "$ros"
    cd "$workspace" || exit
    catkin_make --force-cmake -DPYTHON_EXECUTABLE="$python" -DCATKIN_ENABLE_TESTING="$1" \
        -DCATKIN_WHITELIST_PACKAGES="$2"
)
