"""Checks of the workspace that contains the working directory, and of files that hide modules."""

import os
import sys
from typing import Iterator, List, Optional

import rospkg

from nodekit.doctor.findings import Finding, fault, ok
from nodekit.shadowed_modules import USED

_INTERFACES = {".msg": "msg", ".srv": "srv", ".action": "msg"}


def check_workspace(folder: str) -> List[Finding]:
    """Check that a workspace is built and sourced, and that its messages are up to date.

    :param folder: a folder in the workspace
    """
    workspace = find_workspace(folder)
    if workspace is None:
        return [ok("workspace", "none here; the sourced workspaces are used")]
    packages = rospkg.RosPack(ros_paths=[os.path.join(workspace, "src")])
    if not packages.list():
        return [ok("workspace", f"no package in {workspace}; the sourced workspaces are used")]
    sourced = rospkg.RosPack()
    findings: List[Finding] = []
    unsourced = []
    for name in sorted(packages.list()):
        path = packages.get_path(name)
        try:
            used = sourced.get_path(name)
        except rospkg.ResourceNotFound:
            unsourced.append(name)
            continue
        if os.path.realpath(used) != os.path.realpath(path):
            advice = "source the intended workspace in a new shell"
            findings.append(fault(name, f"{path} is hidden by the copy in {used}", advice))
            continue
        findings += _outdated_interfaces(name, path)
        findings += _shadowing_scripts(path)
    if unsourced:
        findings.append(_unsourced(workspace, unsourced))
    return findings or [ok("workspace", f"{workspace} is built and sourced")]


def find_workspace(folder: str) -> Optional[str]:
    """Return the catkin workspace that contains a folder, None outside a workspace.

    :param folder: path
    """
    folder = os.path.realpath(folder)
    while True:
        marks = (".catkin_workspace", ".catkin_tools", "devel/.catkin", "src/CMakeLists.txt")
        is_marked = any(os.path.exists(os.path.join(folder, mark)) for mark in marks)
        if is_marked and os.path.isdir(os.path.join(folder, "src")):
            return folder
        parent = os.path.dirname(folder)
        if parent == folder:
            return None
        folder = parent


def _unsourced(workspace: str, names: List[str]) -> Finding:
    """Return what to do about packages of a workspace that ROS does not find."""
    shown = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
    setup = os.path.join(workspace, "devel", "setup.bash")
    if not os.path.exists(setup):
        has_tools = os.path.exists(os.path.join(workspace, ".catkin_tools"))
        command = "catkin build" if has_tools else "catkin_make"
        return fault(workspace, f"not built ({shown})", f"cd {workspace} && {command}")
    if os.path.join(workspace, "devel") in os.environ.get("CMAKE_PREFIX_PATH", "").split(":"):
        return fault(shown, "not found, though the workspace is sourced", "build again")
    return fault(workspace, f"not sourced in this shell ({shown})", f"source {setup}")


def _outdated_interfaces(name: str, path: str) -> Iterator[Finding]:
    """Yield a fault for each message or service that is newer than the code built from it."""
    for suffix in ("msg", "srv", "action"):
        folder = os.path.join(path, suffix)
        for file in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
            stem, ending = os.path.splitext(file)
            if ending not in _INTERFACES:
                continue
            stem += "Action" if ending == ".action" else ""
            built = _find_module(f"{name}/{_INTERFACES[ending]}/_{stem}.py")
            source = os.path.join(folder, file)
            if built is None:
                yield fault(f"{name}/{file}", "no code was generated from it", _generate(name))
            elif os.path.getmtime(built) < os.path.getmtime(source):
                yield fault(f"{name}/{file}", f"newer than {built}", "build the workspace again")


def _generate(name: str) -> str:
    return f"list it in CMakeLists.txt of {name}, with generate_messages(), and build again"


def _find_module(path: str) -> Optional[str]:
    """Return the first file of a relative path on the module search path."""
    paths = (os.path.join(folder, path) for folder in sys.path)
    return next((path for path in paths if os.path.exists(path)), None)


def _shadowing_scripts(path: str) -> Iterator[Finding]:
    """Yield a fault for each script of a package that hides a module from its neighbours."""
    for folder, _, files in os.walk(path):
        scripts = {file for file in files if os.access(os.path.join(folder, file), os.X_OK)}
        for file in sorted(files):
            module, ending = os.path.splitext(file)
            if ending == ".py" and module in USED and scripts and "__init__.py" not in files:
                yield fault(
                    os.path.join(folder, file),
                    f"hides the module {module} from the scripts beside it",
                    "rename the file",
                )
