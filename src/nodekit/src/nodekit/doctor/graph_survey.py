"""Survey of the graph: queries master, nodes and publishers, and returns a Snapshot."""

import contextlib
import dataclasses
import errno
import http.client
import io
import socket
import struct
import time
import xmlrpc.client
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Dict, FrozenSet, List, Optional, Tuple
from urllib.parse import urlsplit

import rosgraph.network

from nodekit.doctor.graph_snapshot import NodeState, Publication, Snapshot, is_loopback
from nodekit.master import CONNECTED_ELSEWHERE, MasterClient, TimeoutTransport

#: Name under which requests are sent.
CALLER = "/doctor"
#: Timeout of a request to a node [s].
_TIMEOUT_S = 3.0
#: Longest wait for a message with a stamp [s].
_MESSAGE_S = 1.5
#: Largest number of nodes queried at a time.
_TOGETHER = 24
#: Pause before connections that were not seen are checked again [s].
_SECOND_LOOK_S = 2.0
_ERRORS = (OSError, http.client.HTTPException, xmlrpc.client.Error, UnicodeError)


def survey(master: MasterClient) -> Snapshot:
    """Return the graph, after asking all of its nodes.

    :param master: client of the master
    :raises MasterUnreachable: if the master does not reply
    """
    state = master.system_state()
    registered = [*state.publishers, *state.subscribers, *state.services]
    names = sorted({node for _, nodes in registered for node in nodes})
    uris = {name: master.lookup_node(name) or "" for name in names}
    publishers, subscribers = dict(state.publishers), dict(state.subscribers)
    with ThreadPoolExecutor(_TOGETHER) as pool:
        answers = pool.map(lambda name: ask_node(uris[name]), names)
        nodes = dict(zip(names, answers))
        pairs = [
            (topic, name)
            for topic, senders in publishers.items()
            for name in senders
            # A publisher without subscribers may have to start its work first.
            if subscribers.get(topic) and not nodes[name].error
        ]
        found = pool.map(lambda pair: ask_publisher(nodes[pair[1]].uri, pair[0]), pairs)
        publications = {pair: answer for pair, answer in zip(pairs, found) if answer}
    return Snapshot(publishers, subscribers, nodes, publications, master.topic_types())


def survey_links(graph: Snapshot) -> Snapshot:
    """Return a graph after reading its nodes' connections again, a moment later.

    A node that has just begun is not connected yet.

    :param graph: an earlier survey
    """
    time.sleep(_SECOND_LOOK_S)
    with ThreadPoolExecutor(_TOGETHER) as pool:
        again = pool.map(lambda node: ask_node(node.uri), graph.nodes.values())
        nodes = {
            name: dataclasses.replace(node, links=new.links if not new.error else None)
            for (name, node), new in zip(graph.nodes.items(), again)
        }
    return dataclasses.replace(graph, nodes=nodes)


def ask_node(uri: str) -> NodeState:
    """Return the state of a node, from its own reply.

    :param uri: URI that it has registered
    """
    host, is_local = "", True
    try:
        host = urlsplit(uri).hostname or ""
        is_local = rosgraph.network.is_local_address(host)
        node = xmlrpc.client.ServerProxy(uri, transport=TimeoutTransport(_TIMEOUT_S))
        pid: Any = _value(node.getPid(CALLER))
        subscriptions = {
            topic: msg_type for topic, msg_type in _value(node.getSubscriptions(CALLER)) or []
        }
        links, has_proxy = _links(node)
        return NodeState(
            uri,
            host,
            is_local,
            pid=pid,
            subscriptions=subscriptions,
            links=links,
            has_proxy=has_proxy,
        )
    except _ERRORS as error:
        return NodeState(uri, host, is_local, *_reason(error, uri, host))
    except (TypeError, ValueError) as error:  # a malformed reply
        return NodeState(uri, host, is_local, f"malformed reply from {uri!r} ({error})", _CLEAN)


_CLEAN = "remove what it has registered: rosnode cleanup"


def _reason(error: Exception, uri: str, host: str) -> Tuple[str, str]:
    """Return why a node does not answer, and what to do."""
    if isinstance(error, ConnectionRefusedError) and is_loopback(host):
        return (
            f"is registered, and nothing listens at {uri} on this machine",
            "remove it if its process has ended: rosnode cleanup; if it runs on another machine, "
            "start it there with ROS_IP set",
        )
    if isinstance(error, ConnectionRefusedError):
        return f"is registered, but its process has ended (nothing listens at {uri})", _CLEAN
    if isinstance(error, socket.gaierror):
        return (
            f"its host name '{host}' is unknown on this machine",
            f"add {host} to /etc/hosts here, or start {{name}} with ROS_IP set",
        )
    if isinstance(error, socket.timeout):
        return (
            f"does not answer within {_TIMEOUT_S:.0f} s at {uri}",
            "resume it if it is stopped; else check the network to its machine, or kill it",
        )
    if isinstance(error, OSError) and error.errno in (errno.EHOSTUNREACH, errno.ENETUNREACH):
        return f"its address is not reachable from this machine ({uri})", (
            "start {name} with ROS_IP set to an address in the network of this machine"
        )
    return f"does not answer at {uri} ({error})", _CLEAN


def _value(reply: Any) -> Any:
    """Return the value of a reply of the slave API, None if it is an error."""
    code, _, value = reply
    return value if code == 1 else None


def _links(
    node: xmlrpc.client.ServerProxy,
) -> Tuple[Optional[FrozenSet[Tuple[str, str]]], bool]:
    """Return links and has_proxy of a NodeState."""
    try:
        reply: Any = node.getBusInfo(CALLER)
        rows = _value(reply)
        links = None if rows is None else frozenset((row[4], row[1]) for row in rows)
        return links, reply[1] == CONNECTED_ELSEWHERE
    except (*_ERRORS, TypeError, ValueError, IndexError):
        return None, False


def ask_publisher(uri: str, topic: str) -> Optional[Publication]:
    """Return a publisher's connection header, and the stamp of a message that it sends.

    :param uri: URI of its node
    :param topic: global name of the topic
    :returns: None if it does not answer as a publisher over TCP
    """
    with contextlib.suppress(
        *_ERRORS,
        LookupError,  # a header that lacks fields, such as a rejection
        TypeError,
        ValueError,
        struct.error,
        rosgraph.network.ROSHandshakeException,
    ):
        node = xmlrpc.client.ServerProxy(uri, transport=TimeoutTransport(_TIMEOUT_S))
        answer: Any = _value(node.requestTopic(CALLER, topic, [["TCPROS"]]))
        if not answer:
            return None
        _, host, port = answer
        fields = {"callerid": CALLER, "topic": topic, "type": "*", "md5sum": "*"}
        with socket.create_connection((host, port), _TIMEOUT_S) as connection:
            connection.sendall(rosgraph.network.encode_ros_handshake_header(fields))
            buffer = io.BytesIO()
            header = rosgraph.network.read_ros_handshake_header(connection, buffer, 4096)
            publication = Publication(header["type"], header["md5sum"])
            offset = stamp_offset(header)
            if offset is None:
                return publication
            stamp = _first_stamp(connection, buffer.getvalue(), offset)
            return dataclasses.replace(publication, stamp=stamp, received_at=time.time())
    return None


def stamp_offset(header: Dict[str, str]) -> Optional[int]:
    """Return the offset of the stamp in messages of a publisher [bytes].

    :param header: fields of the publisher's connection header
    :returns: None for messages without a stamp, and for latched ones, which may be old
    """
    if header.get("latching") == "1":
        return None
    if header["type"] == "rosgraph_msgs/Clock":
        return 0
    lines = (
        line.split("#")[0].split() for line in header.get("message_definition", "").split("\n")
    )
    first: List[str] = next((words for words in lines if words), [])
    # The sequence number precedes the stamp.
    return 4 if first[:1] in (["Header"], ["std_msgs/Header"]) else None


def _first_stamp(connection: socket.socket, received: bytes, offset: int) -> Optional[float]:
    """Return the stamp of the first message on a connection [s], None after the timeout."""
    start = 4 + offset  # after the message's length
    end = time.monotonic() + _MESSAGE_S
    with contextlib.suppress(socket.timeout):
        while len(received) < start + 8:
            connection.settimeout(max(0.01, end - time.monotonic()))
            part = connection.recv(4096)
            if not part:
                return None
            received += part
        seconds, nanoseconds = struct.unpack_from("<II", received, start)
        return float(seconds) + 1e-9 * float(nanoseconds)
    return None
