"""Installation of the library rosbags, which reads ROS 2 recordings, in a private folder.

Debian has no package of it. ``rosrun topic_scope fetch_rosbags.py`` fetches it from PyPI, with the
hashes in ``config/rosbags.txt``, into ``build`` of the workspace, or else into ROS's folder in the
user's home.
"""

import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile
from typing import List

import rospkg

#: Command that installs it.
COMMAND = "rosrun topic_scope fetch_rosbags.py"
#: Timeouts for creating an empty environment, and for the download [s].
_VENV_LIMIT_S, _FETCH_LIMIT_S = 300.0, 600.0


class Unavailable(Exception):
    """Error of a library that cannot be fetched; the text states the reason."""


def enter() -> None:
    """Add the library to Python's path.

    :raises ModuleNotFoundError: if it has not been fetched
    """
    for folder in map(str, _places()):
        if folder in sys.path:
            return
        if os.path.isdir(folder):
            sys.path.insert(0, folder)
            return
    raise ModuleNotFoundError("No module named 'rosbags'", name="rosbags")


def fetch() -> pathlib.Path:
    """Fetch the library unless it is installed.

    :returns: its folder
    :raises Unavailable: if that is not possible
    """
    place = _places()[0]
    if place.exists():
        return place
    place.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=str(place.parent)) as scratch:
        new, environment = os.path.join(scratch, "new"), os.path.join(scratch, "environment")
        _run([sys.executable, "-m", "venv", environment], _VENV_LIMIT_S)
        pip = [os.path.join(environment, "bin", "python"), "-m", "pip", "install", "--target", new]
        options = ["--no-deps", "--require-hashes", "--only-binary", ":all:", "--retries", "1"]
        quiet = ["--quiet", "--disable-pip-version-check", "--no-compile"]
        _run([*pip, *options, *quiet, "--requirement", str(_wheels())], _FETCH_LIMIT_S)
        os.rename(new, str(place))  # atomic: an existing folder is complete
    return place


def _run(command: List[str], limit: float) -> None:
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    try:
        subprocess.run(
            command,
            check=True,
            env=variables,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=limit,
        )
    except subprocess.TimeoutExpired:
        raise Unavailable(f"not finished within {limit:g} s") from None
    except subprocess.CalledProcessError as error:
        lines = error.stdout.decode("utf-8", "replace").splitlines() or ["no output"]
        errors = [line for line in lines if "error" in line.lower()] or lines[-1:]
        raise Unavailable(errors[-1].strip()) from None
    except OSError as error:
        raise Unavailable(f"{command[0]}: {error.strerror}") from None


def _wheels() -> pathlib.Path:
    return pathlib.Path(rospkg.RosPack().get_path("topic_scope")) / "config" / "rosbags.txt"


def _places() -> List[pathlib.Path]:
    """Return the possible folders of the library for this Python, the default first."""
    version = "%d.%d" % sys.version_info[:2]
    digest = hashlib.sha256(_wheels().read_bytes()).hexdigest()[:8]
    name = f"rosbags-python{version}-{digest}"
    built = [parent / "build" for parent in pathlib.Path(__file__).resolve().parents]
    home = pathlib.Path(rospkg.get_ros_home()).absolute() / "topic_scope"
    return [*(one / name for one in built if (one / "CATKIN_IGNORE").exists()), home / name]
