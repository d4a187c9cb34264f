"""A second bridge between the same master and domain is refused."""

import contextlib
import socket
import sys
import uuid
from typing import Any

import pytest

from nodekit import CallError
from ros2_bridge.ros1 import single_instance


@pytest.mark.parametrize("given, taken", [("", 0), ("0", 0), ("232", 232)])
def test_domain_is_that_of_the_environment(
    given: str, taken: int, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", given)
    assert single_instance.domain() == taken


@pytest.mark.parametrize("given", ["233", "-1", "1.5", "lab"])
def test_domain_that_has_no_ports_is_refused(given: str, monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", given)
    with pytest.raises(ValueError, match=f"ROS_DOMAIN_ID is '{given}': must be .* in .0, 232."):
        single_instance.domain()


def test_second_bridge_of_a_machine_is_refused_however_its_master_is_spelled(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    def probe(*_: Any) -> Any:
        raise CallError("it hangs")

    monkeypatch.setattr(single_instance, "probe_service", probe)
    monkeypatch.setattr(single_instance, "end", sys.exit)
    monkeypatch.setenv("ROS_DOMAIN_ID", "231")
    master = f"http://{uuid.uuid4()}:11311"
    with contextlib.ExitStack() as sockets:

        def start(uri: str) -> None:
            held = sockets.enter_context(socket.socket(socket.AF_UNIX))
            monkeypatch.setattr(single_instance, "_held", held)
            monkeypatch.setenv("ROS_MASTER_URI", uri)
            single_instance.exit_if_second()

        start(master)
        with pytest.raises(SystemExit, match="another bridge on this machine already connects"):
            start(f"{master}/")
        start(f"http://{uuid.uuid4()}:11311")
