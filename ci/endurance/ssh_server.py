"""ssh server on the far host that accepts one key, created for it."""

import pathlib
import subprocess
from typing import List

from ..benchmark.recorder import wait_until
from .hosts import ADDRESSES, Hosts

#: An empty directory that the server requires.
PRIVILEGE_SEPARATION = pathlib.Path("/run/sshd")

CONFIGURATION = """\
ListenAddress {address}
HostKey {directory}/host_key
AuthorizedKeysFile {directory}/authorized_keys
PidFile none
StrictModes no
UsePAM no
PasswordAuthentication no
KbdInteractiveAuthentication no
PermitRootLogin prohibit-password
SetEnv ROS_HOME={hosts}/ros ROS_LOG_DIR={hosts}/ros/log
"""


def start(hosts: Hosts) -> None:
    """Start the server, and allow the near host's user to log in."""
    directory = hosts.directory / "ssh"
    directory.mkdir()
    home = hosts.directory / "near" / ".ssh"
    home.mkdir(parents=True)
    key = home / "id_ed25519"
    for file in (directory / "host_key", key):
        make_key = ["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(file)]
        subprocess.run(make_key, check=True)
    address = ADDRESSES["far"]
    public = (directory / "host_key.pub").read_text()
    (home / "known_hosts").write_text(f"{address} {public}")
    (directory / "authorized_keys").write_text(key.with_suffix(".pub").read_text())
    configuration = directory / "sshd_config"
    configuration.write_text(
        CONFIGURATION.format(address=address, directory=directory, hosts=hosts.directory)
    )
    if not PRIVILEGE_SEPARATION.exists():
        PRIVILEGE_SEPARATION.mkdir()
        hosts.undo.append(PRIVILEGE_SEPARATION.rmdir)
    hosts.start_on("far", ["/usr/sbin/sshd", "-D", "-e", "-f", str(configuration)])
    wait_until(lambda: bool(hosts.run_on("far", ["ss", "-Hltn", "sport = 22"])), 10.0, "ssh server")


def command(hosts: Hosts, *words: str) -> List[str]:
    """Return the command that runs a command on the far host by ssh.

    OpenSSH's client looks for the home directory in the user database, not in the environment.
    """
    home = hosts.directory / "near" / ".ssh"
    options = ["-F", "none", "-i", str(home / "id_ed25519"), "-o", "BatchMode=yes"]
    options += ["-o", f"UserKnownHostsFile={home / 'known_hosts'}"]
    return ["ssh", *options, "root@" + ADDRESSES["far"], *words]
