"""Command ``rosrun nodekit new``: new package from a template."""

import argparse
import importlib.util
import keyword
import os
import pathlib
import re
import shutil
import sys
from typing import Dict, Optional

from nodekit.package_version import ShowVersion
import rospkg

#: Placeholder of the package name in the template's texts and paths.
PLACEHOLDER = "package_name"
#: Names that both REP 144 and Python allow.
_NAME = re.compile(r"[a-z](_?[a-z0-9])+")
_MUST_BE = "must be lowercase letters, digits and single underscores, a letter first, at least two"


class NewPackageError(Exception):
    """Error of a package that cannot be created; the text is for the user."""


def main() -> None:
    """Create a package that builds, runs and passes its test."""
    parser = argparse.ArgumentParser(
        prog="new",
        description="Create a package with a node, its live parameters, its launch file and its"
        " test: it builds, runs and passes its test without changes.",
    )
    parser.add_argument("--version", action=ShowVersion, package="nodekit")
    parser.add_argument("name", metavar="NAME", help="name of the package")
    where = "folder to create it in; by default the src of the current workspace"
    parser.add_argument("folder", metavar="FOLDER", nargs="?", help=where)
    arguments = parser.parse_args()
    packages = rospkg.RosPack()
    template = pathlib.Path(packages.get_path("nodekit"), "template", PLACEHOLDER)
    try:
        check_name(arguments.name, packages)
        folder = arguments.folder or source_folder(pathlib.Path.cwd())
        created = make(arguments.name, pathlib.Path(folder), template)
    except NewPackageError as error:
        sys.exit(f"new: {error}")
    build = build_command(pathlib.Path(folder).resolve())
    print(f"made {created}\nnext: build the workspace with {build}, source devel/setup.bash, then")
    print(f"  roslaunch {arguments.name} my_node.launch")


def build_command(folder: pathlib.Path) -> str:
    """Return the command that builds the workspace of a folder.

    :param folder: a folder of its sources
    """
    # catkin_tools marks its workspaces; catkin_make refuses to build in their spaces.
    around = (folder, *folder.parents)
    marked = any((place / ".catkin_tools").is_dir() for place in around)
    return "catkin build" if marked else "catkin_make"


def check_name(name: str, packages: rospkg.RosPack) -> None:
    """Check the name of a new package.

    :param packages: the existing packages
    :raises NewPackageError: if the name is not allowed, or taken
    """
    if _NAME.fullmatch(name) is None:
        raise NewPackageError(f"package name '{name}': {_MUST_BE}")
    if name == PLACEHOLDER or keyword.iskeyword(name) or _is_taken_by_python(name):
        raise NewPackageError(f"package name '{name}': already used by Python")
    if name in packages.list():
        raise NewPackageError(f"package name '{name}': already exists in {packages.get_path(name)}")


def _is_taken_by_python(name: str) -> bool:
    """Return whether the system has a module of that name.

    A module in a workspace may be left over from a package that was removed.
    """
    spec = importlib.util.find_spec(name)
    if spec is None:
        return False
    places = [spec.origin or "", *(spec.submodule_search_locations or [])]
    system = os.path.join(sys.base_prefix, "")
    return spec.origin in ("built-in", "frozen") or any(p.startswith(system) for p in places)


def source_folder(here: pathlib.Path) -> pathlib.Path:
    """Return the src of the workspace that a folder is in.

    :param here: the folder
    :raises NewPackageError: if it is not in a workspace
    """
    for folder in (here, *here.parents):
        if (folder / "src").is_dir() and not _package_around(folder):
            return folder / "src"
    raise NewPackageError(
        f"{here} is not in a workspace: go to one that has a src, or name a FOLDER"
    )


def _package_around(folder: pathlib.Path) -> Optional[pathlib.Path]:
    """Return the package that a folder is in, if any."""
    around = (folder, *folder.parents)
    return next((place for place in around if (place / "package.xml").is_file()), None)


def make(name: str, folder: pathlib.Path, template: pathlib.Path) -> pathlib.Path:
    """Create a package, or nothing on an error.

    :param name: its name, already checked
    :param folder: the folder to create it in
    :param template: folder of the template
    :returns: its folder
    :raises NewPackageError: if it cannot be created
    """
    folder = folder.resolve()
    package, around = folder / name, _package_around(folder)
    if around:
        raise NewPackageError(
            f"{folder} is inside the package {around}, where catkin finds no other"
        )
    files: Dict[str, str] = {}
    for path in sorted(template.rglob("*")):
        if path.is_file() and path.suffix != ".pyc":
            relative = str(path.relative_to(template)).replace(PLACEHOLDER, name)
            files[relative] = path.read_text("utf-8").replace(PLACEHOLDER, name)
    try:
        package.mkdir()
    except FileNotFoundError:
        raise NewPackageError(f"there is no folder {folder}") from None
    except OSError as error:
        raise NewPackageError(f"{package} cannot be created: {error.strerror}") from None
    try:
        for relative, text in files.items():
            path = package / relative
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, "utf-8")
            if text.startswith("#!"):
                path.chmod(path.stat().st_mode | 0o111)
    except OSError as error:
        shutil.rmtree(str(package), ignore_errors=True)
        raise NewPackageError(f"{package} cannot be created: {error.strerror}") from None
    return package
