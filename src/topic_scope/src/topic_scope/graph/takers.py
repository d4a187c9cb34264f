"""Ask nodes which type of message they take: the master knows one type for each topic only.

It is that of whoever came first, and it stays when a node starts again with another one.
"""

import xmlrpc.client
from typing import Any, Collection, Optional

import rosgraph

from topic_scope.graph.bus import Transport


def taken_type(
    caller: str, topic: str, nodes: Collection[str], known: Collection[str]
) -> Optional[str]:
    """Return the type that the subscribers of a topic take; waits for them.

    :param caller: name of the node that asks
    :param topic: the topic
    :param nodes: its subscribers
    :param known: types that count; what listens to anything does not
    :returns: the first such type, None if no subscriber takes any
    """
    master = rosgraph.Master(caller)
    for node in sorted(nodes):
        try:
            uri = master.lookupNode(node)
            with xmlrpc.client.ServerProxy(uri, transport=Transport()) as proxy:
                answer: Any = proxy.getSubscriptions(caller)
            types = [datatype for name, datatype in answer[2] if name == topic]
        except Exception:  # whatever a node that is ending, or is none, may answer
            continue
        for datatype in types:
            if datatype in known:
                return str(datatype)
    return None
