# The rc file of the shell that ci/exec opens. The user's own comes first, but may
# not undo the environment: it often puts another python or another ROS on PATH.
# shellcheck shell=bash disable=SC1090
exported=$(export -p)
[ ! -f ~/.bashrc ] || source ~/.bashrc
eval "$exported"
unset exported
PS1="(ci/exec) $PS1"
# roscd and the like: Debian does not bring them in with setup.bash.
for rosbash in "${ROS_ROOT-}/../rosbash/rosbash" /usr/share/bash-completion/completions/rosbash; do
    [ ! -f "$rosbash" ] || source "$rosbash"
done
unset rosbash
