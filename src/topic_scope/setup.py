"""Python package description, read by catkin_python_setup() in CMakeLists.txt only."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["topic_scope", "topic_scope.nodes"],
        package_dir={"": "src"},
    )
)
