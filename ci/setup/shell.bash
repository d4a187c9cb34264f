# The rc file of the shell that ci/exec opens. The user's own rc file runs first, but
# must not undo the environment: it often puts another python or ROS on PATH.
# shellcheck shell=bash disable=SC1090
exported=$(export -p)
[ ! -f ~/.bashrc ] || source ~/.bashrc
eval "$exported"
unset exported
PS1="(ci/exec) $PS1"
# roscd and similar commands: Debian's setup.bash does not define them.
for rosbash in "${ROS_ROOT-}/../rosbash/rosbash" /usr/share/bash-completion/completions/rosbash; do
    [ ! -f "$rosbash" ] || source "$rosbash"
done
unset rosbash
