"""Python package description, read by catkin_python_setup() in CMakeLists.txt only."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["motor_control", "motor_control.nodes"],
        package_dir={"": "src"},
    )
)
