"""Version of a package: that of its manifest, and the commit of its source or Debian package."""

import argparse
import os
import subprocess
from typing import Any, List, Optional, Sequence, Union

import rospkg

#: Longest time of a request to git or dpkg [s].
_TIMEOUT_S = 5.0


def package_version(package: str) -> str:
    """Return the version of a package that is on ROS's package path.

    :param package: name of the package
    :returns: ``1.0.0, commit abc1234, with changes`` for a source in git, ``1.0.1~git…`` for a
        Debian package between two releases, else the version of the manifest
    :raises rospkg.ResourceNotFound: if the package is not found
    """
    packages = rospkg.RosPack()
    manifest = os.path.realpath(os.path.join(packages.get_path(package), "package.xml"))
    version = str(packages.get_manifest(package).version)
    commit = _commit(os.path.dirname(manifest))
    if commit is not None:
        return f"{version}, {commit}"
    return _debian_version(manifest) or version


class ShowVersion(argparse.Action):
    """Option that prints the version of a package, and ends the program.

    :param package: name of the package
    """

    def __init__(self, option_strings: Sequence[str], dest: str, package: str) -> None:
        super().__init__(option_strings, dest, nargs=0, help="show the version and exit")
        self._package = package

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Union[str, Sequence[Any], None],
        option_string: Optional[str] = None,
    ) -> None:
        print(f"{parser.prog} of {self._package} {package_version(self._package)}")
        parser.exit()


def _commit(folder: str) -> Optional[str]:
    """Return the commit of a folder in a git repository; None for any other folder."""
    # A folder that git ignores, such as an install space, is not part of the commit.
    if _output(["git", "-C", folder, "ls-files", "package.xml"]) in (None, ""):
        return None
    commit = _output(["git", "-C", folder, "rev-parse", "--short=7", "HEAD"])
    if commit is None:
        return None
    changes = _output(["git", "-C", folder, "status", "--porcelain", "--", "."])
    return f"commit {commit}, with changes" if changes else f"commit {commit}"


def _debian_version(manifest: str) -> Optional[str]:
    """Return the version of the Debian package that a file belongs to; None without one."""
    owner = _output(["dpkg-query", "--search", manifest])
    if not owner:
        return None
    return _output(["dpkg-query", "--show", "--showformat=${Version}", owner.split(":")[0]])


def _output(command: List[str]) -> Optional[str]:
    """Return the output of a command; None if it fails, hangs or is missing."""
    try:
        done = subprocess.run(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=_TIMEOUT_S,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.decode("utf-8", "replace").strip()
