# Pure: knows no ROS.
"""Check for files beside a script, or on PYTHONPATH, that hide modules of Python or ROS.

A script called signal.py is imported in place of Python's module, by rospy, and the error is about
a circular import.
"""

import os
import sys
from typing import Mapping, Sequence

#: Top-level names of the modules that rospy and nodekit import.
USED = (
    "argparse array atexit base64 bisect calendar collections concurrent contextlib copy copyreg "
    "ctypes dataclasses datetime decimal email enum errno fcntl functools gc genericpath genmsg "
    "genpy getpass glob hashlib heapq html http importlib inspect io itertools json keyword locale "
    "logging math mmap numbers numpy opcode operator os pickle platform posixpath pwd queue random "
    "re resource rosgraph rosgraph_msgs roscpp roslib rospkg rospy select selectors shlex shutil "
    "signal socket socketserver ssl stat std_msgs std_srvs string struct subprocess sys tempfile "
    "textwrap threading time token tokenize traceback types typing urllib uuid warnings weakref "
    "xml xmlrpc yaml zipfile zlib"
).split()


def check_script_folder(arguments: Sequence[str]) -> None:
    """End the program with one sentence if a file beside its script hides a module.

    :param arguments: arguments of the command line; the first is the script
    :raises SystemExit: if a file hides a module
    """
    script = os.path.realpath(arguments[0] if arguments else "")
    folder = os.path.dirname(script)
    # Python puts it first; catkin's development space puts its own folders before it.
    is_of_python = folder == os.path.dirname(os.path.realpath(os.__file__))  # as pydoc is
    if not os.path.isfile(script) or folder not in sys.path or is_of_python:
        return
    for name in USED:
        path = os.path.join(folder, name + ".py")
        if os.path.isfile(path) and _is_imported_from(name, path):
            sys.exit(
                f"{path}: the file hides the module {name}, which every node needs, from "
                f"{os.path.basename(script)}; rename the file"
            )


def warn_of_hidden_modules(environ: Mapping[str, str]) -> None:
    """Print a warning for each file on ``PYTHONPATH`` that hides a module; not all are harmful.

    :param environ: variables of the environment
    """
    python = os.path.dirname(os.path.realpath(os.__file__))
    for folder in filter(None, environ.get("PYTHONPATH", "").split(os.pathsep)):
        if os.path.realpath(folder) == python:
            continue
        try:
            hiding = {name + ".py" for name in USED} & {*os.listdir(folder)}
        except OSError:  # no such folder, which Python ignores, too
            continue
        for name in sorted(hiding):
            print(
                f"{os.path.join(folder, name)}: the file is on PYTHONPATH and hides the module "
                f"{name[:-3]} from every program; rename the file",
                file=sys.stderr,
            )


def _is_imported_from(name: str, path: str) -> bool:
    """Return whether ``import name`` uses a file, not a built-in or already loaded module."""
    if name in sys.builtin_module_names:
        return False
    loaded = getattr(sys.modules.get(name), "__file__", None) or path
    return os.path.realpath(loaded) == os.path.realpath(path)
