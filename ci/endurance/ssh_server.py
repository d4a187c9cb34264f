"""An ssh server on the far host that lets in one key, made for it."""

import pathlib
import subprocess
from typing import List

from ..benchmark.observers import wait_until
from .hosts import ADDRESSES, Hosts

#: where the server wants an empty directory, whatever it is told
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
    """Start the server, and make the near host's user one that may log in."""
    directory = hosts.directory / "ssh"
    directory.mkdir()
    home = hosts.directory / "near" / ".ssh"
    home.mkdir(parents=True)
    key = home / "id_ed25519"
    make_key(directory / "host_key")
    make_key(key)
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
    hosts.start("far", ["/usr/sbin/sshd", "-D", "-e", "-f", str(configuration)])
    wait_until(lambda: bool(hosts.run("far", ["ss", "-Hltn", "sport = 22"])), 10.0, "ssh server")


def make_key(file: pathlib.Path) -> None:
    """Make a key without a passphrase, and its public half beside it."""
    subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(file)], check=True)


def command(hosts: Hosts, *words: str) -> List[str]:
    """Return the command that runs a command on the far host by ssh.

    OpenSSH's client looks for the home directory in the user database, not in the environment.
    """
    home = hosts.directory / "near" / ".ssh"
    options = ["-F", "none", "-i", str(home / "id_ed25519"), "-o", "BatchMode=yes"]
    options += ["-o", f"UserKnownHostsFile={home / 'known_hosts'}"]
    return ["ssh", *options, "root@" + ADDRESSES["far"], *words]
