# Pure: knows no ROS.
"""Checks of the graph: silent nodes, types that differ, missing connections, and wrong clocks."""

import collections
import difflib
from typing import Callable, Dict, List, Optional, Set

from nodekit.doctor.findings import Finding, fault, note, ok
from nodekit.doctor.graph_snapshot import Snapshot, is_loopback

#: Topics of ROS itself, which need not have both publishers and subscribers.
_OF_ROS = ("/rosout", "/rosout_agg", "/clock", "/tf", "/tf_static", "/diagnostics")
#: Smallest similarity of two names that suggests a typing error, as difflib's ratio.
_ALIKE = 0.8
#: Largest difference of two clocks that is not reported [s].
_CLOCK_TOLERANCE_S = 1.0


def check_nodes(graph: Snapshot) -> List[Finding]:
    """Report nodes that do not answer, and nodes that other machines cannot reach."""
    findings = []
    for name, node in sorted(graph.nodes.items()):
        if node.error:
            findings.append(fault(name, node.error, node.remedy.replace("{name}", name)))
    hosts = {node.host for node in graph.nodes.values() if not node.is_local and not node.error}
    for name, node in sorted(graph.nodes.items()):
        if hosts and node.is_local and is_loopback(node.host):
            findings.append(
                fault(
                    name,
                    f"announces itself as {node.host}, where nodes on {_list(hosts)} cannot reach"
                    " it",
                    "start it with ROS_IP set to this machine's address in their network",
                )
            )
    for host in sorted(hosts):
        findings.append(
            note(
                host,
                "cannot tell from here whether its nodes reach this machine",
                "run doctor there, too",
            )
        )
    answering = sum(not node.error for node in graph.nodes.values())
    return [*findings, ok("nodes", f"{answering} of {len(graph.nodes)} answer")]


def check_types(graph: Snapshot, local_md5sum: Callable[[str], Optional[str]]) -> List[Finding]:
    """Report topics with more than one type, or with different definitions of it.

    :param graph: the graph
    :param local_md5sum: returns the checksum of a type's local definition, None if missing
    """
    findings = []
    for topic in sorted({*graph.publishers, *graph.subscribers}):
        sides = _types_of(graph, topic)
        if len(sides) > 1:
            uses = ", ".join(
                f"{msg_type} in {_list(nodes)}" for msg_type, nodes in sorted(sides.items())
            )
            findings.append(
                fault(topic, f"has several types: {uses}", "remap one of them, or correct its type")
            )
            continue
        for msg_type in sides:
            findings += _definitions(graph, topic, msg_type, local_md5sum(msg_type))
    return findings


def _types_of(graph: Snapshot, topic: str) -> Dict[str, Set[str]]:
    """Return the nodes by the type that they use for a topic; ``*`` is any type."""
    found: Dict[str, Set[str]] = collections.defaultdict(set)
    for node in graph.publishers.get(topic, []):
        if (topic, node) in graph.publications:
            found[graph.publications[topic, node].type_name].add(node)
    for node in graph.subscribers.get(topic, []):
        if node in graph.nodes and topic in graph.nodes[node].subscriptions:
            found[graph.nodes[node].subscriptions[topic]].add(node)
    return {msg_type: nodes for msg_type, nodes in found.items() if msg_type not in ("*", "")}


def _definitions(graph: Snapshot, topic: str, msg_type: str, local: Optional[str]) -> List[Finding]:
    """Compare the definitions of one type by their checksums."""
    sums: Dict[str, Set[str]] = collections.defaultdict(set)
    for node in graph.publishers.get(topic, []):
        publication = graph.publications.get((topic, node))
        if publication and publication.md5sum != "*":
            sums[publication.md5sum].add(node)
    if local is None and sums:
        return [
            note(
                topic,
                f"definition of {msg_type} missing here, so rostopic echo cannot show it",
                f"build and source the workspace of {msg_type.partition('/')[0]} in this shell",
            )
        ]
    if local is not None:
        sums[local].add("this shell")
    if len(sums) < 2:
        return []
    uses = ", ".join(f"md5sum {md5} in {_list(nodes)}" for md5, nodes in sorted(sums.items()))
    advice = f"build all of them with the same definition of {msg_type}"
    return [fault(topic, f"different definitions of {msg_type}: {uses}", advice)]


def check_links(graph: Snapshot) -> List[Finding]:
    """Report pairs of nodes that share a topic of one type and are not connected.

    The publisher's list decides: a subscriber of rospy lists a connection that it only attempts.
    """
    findings = []
    connected = 0
    for topic, publishers in sorted(graph.publishers.items()):
        if len(_types_of(graph, topic)) > 1:
            continue
        for publisher in publishers:
            for subscriber in graph.subscribers.get(topic, []):
                sender, receiver = graph.nodes.get(publisher), graph.nodes.get(subscriber)
                if sender is None or receiver is None:
                    continue
                if sender.links is None or receiver.error:
                    continue
                if sender.has_proxy or receiver.has_proxy:
                    continue
                if (topic, subscriber) in sender.links:
                    connected += 1
                    continue
                findings.append(
                    fault(
                        topic,
                        f"{subscriber} is not connected to {publisher} ({sender.uri})",
                        f"look into the log of {subscriber}; check that its machine reaches this"
                        " address, and that both are built with the same definitions",
                    )
                )
    return [*findings, ok("connections", f"{connected} between publishers and subscribers")]


def check_sides(graph: Snapshot) -> List[Finding]:
    """Report topics without publishers, and similar names that lack only subscribers."""
    findings = []
    unheard = {
        topic
        for topic in graph.publishers
        if not graph.subscribers.get(topic) and topic not in _OF_ROS
    }
    for topic, nodes in sorted(graph.subscribers.items()):
        if graph.publishers.get(topic) or topic in _OF_ROS:
            continue
        types = set(_types_of(graph, topic))
        alike = {
            other
            for other in unheard
            if (not types or graph.types.get(other) in types)
            and not {*nodes} & {*graph.publishers[other]}
        }
        near = nearest_topic(topic, alike)
        problem = f"{_list(set(nodes))} subscribes, and no node publishes"
        if near:
            senders = _list(set(graph.publishers[near]))
            problem += f"; {senders} publishes {near}, to which no node subscribes"
            remedy = f"remap one to the other, such as {topic}:={near}, if they belong together"
            findings.append(fault(topic, problem, remedy))
        else:
            findings.append(note(topic, problem))
    return findings


def nearest_topic(topic: str, others: Set[str]) -> Optional[str]:
    """Return the topic whose base name is the same, or a letter or two apart.

    :param topic: global name
    :param others: global names to choose from
    :returns: the nearest of them, None if no base name is near
    """
    base = _base_name(topic)
    near = difflib.get_close_matches(base, map(_base_name, others), n=1, cutoff=_ALIKE)
    found = sorted(other for other in others if [_base_name(other)] == near)
    return max(found, key=lambda other: _likeness(topic, other)) if found else None


def _base_name(topic: str) -> str:
    return topic.rpartition("/")[2].lower()


def _likeness(one: str, other: str) -> float:
    return difflib.SequenceMatcher(None, one, other).ratio()


def check_clocks(graph: Snapshot, use_sim_time: bool) -> List[Finding]:
    """Compare time stamps that publishers send with the clock that they should follow.

    :param graph: the graph
    :param use_sim_time: value of the parameter /use_sim_time
    """
    if use_sim_time and not graph.publishers.get("/clock"):
        advice = "start the simulator or the bag player with --clock, or unset /use_sim_time"
        return [fault("/clock", "/use_sim_time is true, and no node publishes the time", advice)]
    findings = []
    simulated = _simulated_time(graph) if use_sim_time else None
    if use_sim_time and graph.subscribers.get("/clock") and simulated is None:
        problem = "no message received: the simulated time does not advance, as in a pause"
        findings.append(note("/clock", problem))
    for (topic, name), publication in sorted(graph.publications.items()):
        node = graph.nodes.get(name)
        if topic == "/clock" or not publication.stamp or node is None:
            continue
        ahead = publication.stamp - publication.received_at
        if use_sim_time:
            is_wall = abs(ahead) < _CLOCK_TOLERANCE_S
            is_apart = simulated and abs(publication.received_at - simulated) > 10
            if is_wall and is_apart:
                findings.append(
                    fault(
                        topic,
                        f"{name} stamps by the wall clock, though /use_sim_time is true",
                        f"restart {name}: a node reads /use_sim_time when it starts",
                    )
                )
        elif abs(ahead) > _CLOCK_TOLERANCE_S:
            side = "ahead of" if ahead > 0 else "behind"
            problem = f"stamps of {name} are {abs(ahead):.1f} s {side} this machine's clock"
            remedy = "a replayed bag or a delay does so; else "
            where = "correct them" if node.is_local else f"synchronise the clock of {node.host}"
            findings.append(note(topic, problem, remedy + where))
    return findings


def _simulated_time(graph: Snapshot) -> Optional[float]:
    stamps = (graph.publications.get(("/clock", name)) for name in graph.publishers["/clock"])
    return next((each.stamp for each in stamps if each and each.stamp is not None), None)


def _list(names: Set[str]) -> str:
    """Return a list of names for a sentence; more than three are only counted."""
    shown = sorted(names)[:3]
    more = len(names) - len(shown)
    return " and ".join([*shown, f"{more} more"] if more else shown)
