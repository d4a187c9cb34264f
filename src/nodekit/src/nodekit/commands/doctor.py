"""Command ``rosrun nodekit doctor``: search for the faults of a ROS system."""

import argparse
import os
import sys
from typing import List, Optional

import rosgraph
import roslib.message
import rospy

from nodekit.doctor.findings import Finding, count_faults, fault, ok, report
from nodekit.doctor.graph_checks import (
    check_clocks,
    check_links,
    check_nodes,
    check_sides,
    check_types,
)
from nodekit.doctor.graph_snapshot import Snapshot
from nodekit.doctor.graph_survey import CALLER, survey, survey_links
from nodekit.doctor.machine_checks import (
    check_address,
    check_launch_arguments,
    check_listening,
    check_master_reaches,
    owner_of_master,
)
from nodekit.doctor.workspace_checks import check_workspace
from nodekit.master import MasterClient, MasterUnreachable
from nodekit.package_version import ShowVersion
from nodekit.process import own_address


def main() -> None:
    """Print the faults of a ROS system, one per line, with cause and remedy."""
    parser = argparse.ArgumentParser(
        prog="doctor",
        description="Check the workspace here, this machine, the master and all running nodes."
        " Faults are printed last, each with a remedy. The exit status is 1 on faults, else 0.",
    )
    parser.add_argument("--version", action=ShowVersion, package="nodekit")
    parser.parse_args(rospy.myargv()[1:])
    own_address.default_to_loopback(os.environ, sys.argv)  # as nodekit's nodes do
    try:
        findings = examine()
    except KeyboardInterrupt:
        sys.exit(130)  # a shell's status after Ctrl-C
    print(report(findings))
    sys.exit(1 if count_faults(findings) else 0)


def examine() -> List[Finding]:
    """Return all findings."""
    findings = [
        *check_workspace(os.getcwd()),
        *check_address(os.environ),
        *check_launch_arguments(),
    ]
    uri = rosgraph.get_master_uri()
    try:
        with MasterClient(CALLER, master_uri=uri) as master:
            findings += _examine_graph(master, uri)
    except MasterUnreachable as error:
        advice = "start one with roscore or roslaunch, or set ROS_MASTER_URI to one that runs"
        findings.append(fault("master", f"no answer at {error}", advice))
    return findings


def _examine_graph(master: MasterClient, uri: str) -> List[Finding]:
    """Return the findings on the master and its graph."""
    pid = master.request([("getPid",)])[0][2]
    owner = owner_of_master(uri, pid)
    whose = (
        f", process {pid} of user {owner}" if owner else ", on another machine or in a container"
    )
    graph = survey(master)
    use_sim_time = master.read(["/use_sim_time"]).values["/use_sim_time"] is True
    return [
        ok("master", uri + whose),
        *check_master_reaches(uri),
        *check_nodes(graph),
        *check_types(graph, local_md5sum),
        *_checked_links(graph),
        *check_sides(graph),
        *check_clocks(graph, use_sim_time),
        *check_listening(graph, pid if owner else None),
    ]


def _checked_links(graph: Snapshot) -> List[Finding]:
    """Check connections; check again if one is missing."""
    findings = check_links(graph)
    return check_links(survey_links(graph)) if count_faults(findings) else findings


def local_md5sum(type_name: str) -> Optional[str]:
    """Return the checksum of a message type in this environment.

    :param type_name: name such as ``std_msgs/String``
    :returns: None if the type is not built or not sourced here
    """
    try:
        message_class = roslib.message.get_message_class(type_name)
    except Exception:  # of any kind: the package's own code runs
        return None
    return None if message_class is None else str(message_class._md5sum)
