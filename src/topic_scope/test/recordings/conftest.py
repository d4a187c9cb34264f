"""The library that reads ROS 2 recordings, fetched from PyPI if missing."""

import pytest

from topic_scope.bag import rosbags_library


@pytest.fixture(scope="session", autouse=True)
def library() -> None:
    rosbags_library.fetch()
    rosbags_library.enter()
