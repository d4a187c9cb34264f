"""Installation of ROS 2's official command line from source, at fixed commits.

Neither PyPI nor Debian has the command line.
"""

import pathlib
import tempfile
from typing import NamedTuple, Sequence, Tuple

from ros2_bridge.environment.python_environment import (
    FETCH_LIMIT_S,
    PythonEnvironment,
    say,
)


class Source(NamedTuple):
    """Git repository of Python packages.

    :param url: its URL
    :param commit: commit of the release
    :param packages: folders of the packages, relative to the repository
    """

    url: str
    commit: str
    packages: Tuple[str, ...]


#: Releases of Jazzy, without commands that need a full ROS 2 installation, such as ``ros2 pkg``.
SOURCES = (
    Source(
        "https://github.com/ros2/rosidl_runtime_py",
        "df2361f64ecb85f65f4bf22e804424e0f1ac4197",  # 0.13.1
        (".",),
    ),
    Source(
        "https://github.com/ros2/ros2cli",
        "de6cd27284937044d8dff47a617581c28865210c",  # 0.32.2
        (
            "ros2cli",
            "ros2node",
            "ros2topic",
            "ros2service",
            "ros2param",
            "ros2lifecycle",
            "ros2action",
            "ros2interface",
        ),
    ),
)


def install(
    environment: PythonEnvironment, wheels: pathlib.Path, sources: Sequence[Source] = SOURCES
) -> None:
    """Install the command line, unless these versions are already installed.

    :param environment: a complete environment
    :param wheels: requirements file with the wheels that the command line needs, with hashes
    :param sources: its repositories
    :raises Unavailable: if the command line cannot be fetched or installed
    """
    stamp = environment.folder / "command_line"
    wanted = "\n".join([*(source.commit for source in sources), wheels.read_text("utf-8")])
    with environment.locked(), tempfile.TemporaryDirectory() as place:
        if stamp.exists() and stamp.read_text("utf-8") == wanted:
            return
        say("fetching the command line of ROS 2 from GitHub, once")
        folders = []
        for number, source in enumerate(sources):
            folder = pathlib.Path(place, str(number))
            _fetch(environment, source, folder)
            folders += [str(folder / package) for package in source.packages]
        pip = [str(environment.python), "-m", "pip", "install", "--no-deps", "--no-compile"]
        pip += ["--quiet", "--retries", "1", "--disable-pip-version-check"]
        for options in (
            ["--only-binary", ":all:", "--require-hashes", "--requirement", str(wheels)],
            ["--no-build-isolation", *folders],
        ):
            environment.run([*pip, *options], FETCH_LIMIT_S, "ros2 cannot be installed")
        stamp.write_text(wanted, "utf-8")


def _fetch(environment: PythonEnvironment, source: Source, folder: pathlib.Path) -> None:
    git = ["env", "GIT_TERMINAL_PROMPT=0", "git", "-C", str(folder)]
    folder.mkdir()
    for options in (
        ["init", "--quiet"],
        # Fetch a commit, not a tag, which could be moved.
        ["fetch", "--quiet", "--depth", "1", source.url, source.commit],
        ["checkout", "--quiet", "FETCH_HEAD"],
    ):
        environment.run(
            [*git, *options], FETCH_LIMIT_S, f"ros2 cannot be fetched from {source.url}"
        )
