"""Python package description, read by catkin_python_setup() in CMakeLists.txt only."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["basic_comms", "basic_comms.nodes", "basic_comms.rospy_internals"],
        package_dir={"": "src"},
    )
)
