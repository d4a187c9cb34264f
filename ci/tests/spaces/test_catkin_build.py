"""Test of ``catkin build`` in a new workspace."""

import pathlib
import subprocess
from typing import Dict

from ci.lint.tables import needed

from .conftest import SOURCES


def test_catkin_build_makes_packages_usable(
    tmp_path: pathlib.Path, underlay: Dict[str, str]
) -> None:
    # One package with messages, launch files and Python, and its dependencies.
    packages = [SOURCES / name for name in sorted(needed("basic_comms"))]
    (tmp_path / "src").mkdir()
    for package in packages:
        (tmp_path / "src" / package.name).symlink_to(package)
    build = ["catkin", "build", "--no-status", "--no-notify", "--workspace", str(tmp_path)]
    subprocess.check_call(
        build + ["--cmake-args", "-DPYTHON_EXECUTABLE=/usr/bin/python3"], env=underlay
    )
    for package in packages:
        find = 'source "$0/devel/setup.bash" && rospack find "$1" && catkin_find --first-only "$1"'
        out = subprocess.check_output(
            ["bash", "-c", find, str(tmp_path), package.name], env=underlay
        ).decode()
        assert out.splitlines()[0] == str(tmp_path / "src" / package.name)
    imports = "import basic_comms.msg as m, basic_comms.nodes; print(m.__file__)"
    out = subprocess.check_output(
        ["bash", "-c", 'source "$0/devel/setup.bash" && python3 -c "$1"', str(tmp_path), imports],
        env=underlay,
    ).decode()
    assert out.startswith(str(tmp_path / "devel"))
