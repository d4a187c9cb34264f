"""The command ``rosrun basic_comms describe NAMESPACE``."""

import argparse
import difflib
import socket
import sys
from typing import List

import rosgraph
import rospy
import yaml
from std_srvs.srv import Trigger

from nodekit.live.description import SERVICE, as_table


def describable(master: rosgraph.Master, namespace: str) -> List[str]:
    """List the namespaces at or below one whose owner describes its parameters.

    :param master: the master to ask
    :param namespace: global name
    :returns: global names, sorted
    :raises socket.error: if there is no master
    """
    prefix = namespace.rstrip("/") + "/"
    _, _, services = master.getSystemState()
    suffix = "/" + SERVICE
    owners = [name[: -len(suffix)] for name, _ in services if name.endswith(suffix)]
    return sorted(owner for owner in owners if (owner + "/").startswith(prefix))


def main() -> None:
    """Print what the nodes below a namespace say of their parameters."""
    parser = argparse.ArgumentParser(
        prog="describe",
        description="Describe the parameters of running nodes: value, type, range, unit and help.",
    )
    parser.add_argument("namespace", metavar="NAMESPACE", help="a node or a group; / for all")
    parser.add_argument("--yaml", action="store_true", help="print YAML for programs to read")
    arguments = parser.parse_args(rospy.myargv()[1:])
    try:
        sys.exit(_describe(rosgraph.names.make_global_ns(arguments.namespace), arguments.yaml))
    except socket.error as error:
        sys.exit("describe: no master at %s (%s)" % (rosgraph.get_master_uri(), error))
    except KeyboardInterrupt:
        pass


def _describe(namespace: str, wants_yaml: bool) -> int:
    master = rosgraph.Master("/describe")
    owners = describable(master, namespace)
    if not owners:
        everyone = describable(master, "/")
        near = difflib.get_close_matches(namespace.rstrip("/"), everyone, n=1) or everyone
        hint = "; there is %s" % ", ".join(near) if near else "; no such node is running"
        print("describe: nothing at %s describes itself%s" % (namespace, hint), file=sys.stderr)
        return 1
    failures = 0
    for owner in owners:
        try:
            answer = rospy.ServiceProxy("%s/%s" % (owner, SERVICE), Trigger)()
        except (rospy.ServiceException, rospy.ROSException) as error:
            print("describe: %s does not answer: %s" % (owner, error), file=sys.stderr)
            failures += 1
            continue
        entries = yaml.safe_load(answer.message)
        if wants_yaml:
            print(yaml.safe_dump({owner: entries}, sort_keys=False, allow_unicode=True), end="")
        else:
            print("%s\n%s" % (owner, as_table(entries)))
    return 1 if failures else 0
