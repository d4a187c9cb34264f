"""The library that reads recordings of ROS 2, fetched from PyPI unless it is there."""

import pytest

from topic_scope.bag import rosbags_library


@pytest.fixture(scope="session", autouse=True)
def library() -> None:
    rosbags_library.fetch()
    rosbags_library.enter()
