"""The typist of the pages notices a line that does not do what it says."""

import os
from typing import Iterator

import pytest
from typist import Line, Typist, lines_of
from warm_python import WarmPython

PAGE = """
```sh
one   # said
```

1. In a list:

   ```sh
   two

   three
   ```

```console
$ four
```
"""


@pytest.fixture(scope="module", autouse=True)
def own_surroundings() -> Iterator[None]:
    """Restore what the typist changes."""
    uri = os.environ.get("ROS_MASTER_URI", "http://localhost:11311")
    yield
    os.environ["ROS_MASTER_URI"] = uri


@pytest.fixture(scope="module")
def typist(python: WarmPython, own_surroundings: None) -> Iterator[Typist]:
    """Return a typist on whose master there is a talker."""
    with Typist(python) as typist:
        typist.type("rosrun basic_comms talker.py")
        yield typist


def test_all_blocks_are_read_and_no_others() -> None:
    assert lines_of(PAGE) == [Line(3, "one   # said"), Line(9, "two"), Line(11, "three")]


@pytest.mark.parametrize(
    "command",
    [
        "true  # a comment",
        "false  # refused",
        "rosparam set /talker/rate 5.0",
        "rosparam set /talker/rate -1  # refused",
        "rostopic echo /chatter",
    ],
)
def test_a_right_line(typist: Typist, command: str) -> None:
    typist.type(command)


@pytest.mark.parametrize(
    "command, reason",
    [
        ("false", "status 1"),
        ("true  # refused", "status 0"),
        ("echo 'success: False'", "status 0:\nsuccess: False"),
    ],
)
def test_a_wrong_line(typist: Typist, command: str, reason: str) -> None:
    with pytest.raises(AssertionError, match=reason):
        typist.type(command)


@pytest.mark.parametrize(
    "command, reason",
    [
        ("exec sleep 60", "does not end"),
        ("rostopic echo /missing", "does not come up"),
        ("rostopic pub /missing std_msgs/String hello", "does not come up"),
    ],
)
def test_a_line_that_has_no_effect(
    typist: Typist, monkeypatch: pytest.MonkeyPatch, command: str, reason: str
) -> None:
    monkeypatch.setattr(typist, "timeout", 1.0)
    with pytest.raises(AssertionError, match=reason):
        typist.type(command)


@pytest.mark.parametrize(
    "command, reason",
    [
        ("rosparam set /talker/rate -1", "in force is"),
        ("rosparam set /talker/rate 5.0  # refused", "in force is"),
        ("rosparam set /missing/rate 5.0", "no node follows it"),
    ],
)
def test_value_that_the_node_treats_otherwise_than_the_page_says(
    typist: Typist, monkeypatch: pytest.MonkeyPatch, command: str, reason: str
) -> None:
    typist.type(
        "env " + command.partition("#")[0]
    )  # may take its time: only the node's reaction is waited for
    monkeypatch.setattr(typist, "timeout", 1.0)
    with pytest.raises(AssertionError, match=reason):
        typist.check_parameter(command)


@pytest.mark.parametrize(
    "command, reason",
    [
        ("rosrun basic_comms missing.py", "it has ended with status 3"),
        ("roslaunch basic_comms missing.launch", "it has ended with status 1"),
        ("roslaunch basic_comms talker_listener.launch wrong:=1", "has no argument wrong"),
    ],
)
def test_what_does_not_come_up(python: WarmPython, command: str, reason: str) -> None:
    with pytest.raises(AssertionError, match=reason), Typist(python) as typist:
        typist.type(command)


def test_a_parameter_that_a_node_does_not_have(python: WarmPython) -> None:
    with pytest.raises(AssertionError, match="rat is not used"), Typist(python) as typist:
        typist.type("rosrun basic_comms talker.py _rat:=2")
