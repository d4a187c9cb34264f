"""Tests of a node's address: loopback by default, rejected if unreachable."""

import os
import re
import signal
import subprocess
import sys
import xmlrpc.client
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Set

import pytest
import rosgraph

from nodekit.process.own_address import default_to_loopback
from nodekit.testing.processes import Master
from nodekit.testing.waiting import TIMEOUT_S, wait_until

#: An address for documentation, RFC 5737.
ELSEWHERE = "192.0.2.77"
NODE = """
import nodekit
from std_msgs.msg import String

class Some:
    def __init__(self, node):
        publisher = node.create_publisher("topic", String)
        node.create_timer(10.0, lambda elapsed: publisher.publish("text"))

if __name__ == "__main__":
    nodekit.run("some", Some)
"""
#: A node of rospy alone, which ends when it has heard the node above.
STOCK = """
import rospy
from std_msgs.msg import String
rospy.init_node("stock")
print(rospy.wait_for_message("/topic", String, 120.0).data)
"""


@pytest.mark.parametrize(
    "uri", ["", "http://localhost:11311", "http://127.0.0.1:2/", "http://[::1]:3"]
)
def test_address_without_a_setting_is_localhost(uri: str) -> None:
    environ = {"ROS_MASTER_URI": uri, "ROS_IP": ""}
    default_to_loopback(environ, ["node.py", "_rate:=2"])
    assert environ == {"ROS_MASTER_URI": uri, "ROS_HOSTNAME": "localhost"}
    default_to_loopback(environ, [])
    assert environ["ROS_HOSTNAME"] == "localhost"


@pytest.mark.parametrize(
    "environ, argv",
    [
        ({"ROS_IP": ELSEWHERE}, []),
        ({"ROS_HOSTNAME": "robot"}, []),
        ({"ROS_MASTER_URI": "http://robot:11311"}, []),
        ({}, ["__ip:=" + ELSEWHERE]),
        ({}, ["__hostname:=robot"]),
        ({}, ["__master:=http://robot:11311"]),
    ],
)
def test_address_that_is_set_is_kept(environ: Dict[str, str], argv: List[str]) -> None:
    before = dict(environ)
    default_to_loopback(environ, argv)
    assert environ == before


@pytest.fixture()
def script(tmp_path: Path) -> str:
    path = tmp_path / "some_node.py"
    path.write_text(NODE)
    return str(path)


@pytest.mark.extended
@pytest.mark.parametrize("name", ["ROS_IP", "ROS_HOSTNAME"])
def test_node_with_the_address_of_another_machine_ends_with_cause_and_remedy(
    script: str, name: str
) -> None:
    environ = {
        key: value for key, value in os.environ.items() if key not in ("ROS_IP", "ROS_HOSTNAME")
    }
    done = subprocess.run(
        [sys.executable, script],
        env={**environ, name: ELSEWHERE},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )
    assert (done.returncode, done.stdout) == (1, "")
    pattern = rf"{name} '{ELSEWHERE}': other nodes cannot reach this one there, .*; set ROS_IP .*\n"
    assert re.fullmatch(pattern, done.stderr), done.stderr


@pytest.fixture()
def unset(monkeypatch: "pytest.MonkeyPatch") -> Iterator[Master]:
    """Give a master, and an environment as a sourced workspace has it."""
    for name in ("ROS_IP", "ROS_HOSTNAME"):
        monkeypatch.delenv(name, raising=False)
    master = Master()
    monkeypatch.setenv("ROS_MASTER_URI", master.uri)
    try:
        yield master
    finally:
        master.kill()


def listening_addresses(pid: int) -> Set[str]:
    """Return the local addresses, in the kernel's digits, at which a process listens."""
    folder = Path(f"/proc/{pid}/fd")
    links = {
        os.readlink(str(link)) for link in folder.iterdir() if link.exists() or link.is_symlink()
    }
    found = set()
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/{pid}/net/{table}").read_text().splitlines()[1:]:
            words = line.split()
            if words[3] == "0A" and f"socket:[{words[9]}]" in links:
                found.add(words[1].partition(":")[0])
    return found


def node_pid(master: Master) -> Optional[int]:
    """Return the process id of the node, None before it is registered."""
    try:
        uri = rosgraph.Master("/test", master.uri).lookupNode("/some")
        server: Any = xmlrpc.client.ServerProxy(uri)
        return int(server.getPid("/test")[2])
    except (rosgraph.MasterError, OSError):
        return None


LAUNCH = """
<launch>
  <node pkg="nodekit" type="host" name="launched" args="some_node:Some"/>
</launch>
"""


@pytest.mark.parametrize(
    "way",
    [
        "script",
        pytest.param("rosrun", marks=pytest.mark.extended),
        pytest.param("roslaunch", marks=pytest.mark.extended),
    ],
)
def test_node_listens_on_loopback_only_and_stock_nodes_reach_it(
    script: str, unset: Master, way: str, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    folder = Path(script).parent
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(folder), os.environ["PYTHONPATH"]]))
    (folder / "some.launch").write_text(LAUNCH.replace("launched", "some"))
    command = {
        "script": [sys.executable, script],
        "rosrun": ["rosrun", "nodekit", "host", "some_node:Some", "__name:=some"],
        "roslaunch": ["roslaunch", str(folder / "some.launch")],
    }[way]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        stock = subprocess.run([sys.executable, "-c", STOCK], stdout=subprocess.PIPE, check=True)
        assert stock.stdout == b"text\n"
        pid = wait_until(lambda: node_pid(unset), lambda: "it is not registered")
        assert listening_addresses(pid) == {"0100007F"}
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(TIMEOUT_S)
