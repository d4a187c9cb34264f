# Pure: knows no ROS.
"""Namespaces in which a talker looks up its message, by the rules of ROS names.

The candidates of a node ``/Group1/talker``, nearest first, are
``/Group1/talker/Message``, ``/Group1/Message`` and ``/Message``.
"""

from typing import Any, List, Mapping, Optional

SCOPES = ("closest", "global", "local", "private")

NOTHING_IN_SCOPE = "No Parameter Found"
NOTHING_ANYWHERE = "hello world"


def candidates(node_name: str, parameter: str = "Message") -> List[str]:
    """Return the names under which a parameter may be set for a node, nearest first.

    :param node_name: global name of the node
    :param parameter: base name of the parameter
    :returns: global names: private, in each enclosing namespace, global
    """
    parts = [part for part in node_name.split("/") if part]
    return ["/" + "/".join(parts[:depth] + [parameter]) for depth in range(len(parts), -1, -1)]


def message_text(found: Mapping[str, Optional[str]], keys: List[str], scope: str) -> str:
    """Return the text to publish.

    :param found: text by global name; None or missing if it is not set
    :param keys: the result of :func:`candidates` for the node
    :param scope: one of SCOPES
    :returns: the text in the scope, or "No Parameter Found" or "hello world"
    """
    if scope == "closest":
        set_ones = [found[key] for key in keys if found.get(key) is not None]
        return set_ones[0] or "" if set_ones else NOTHING_ANYWHERE
    key = {"private": keys[0], "local": keys[1], "global": keys[-1]}[scope]
    text = found.get(key)
    return text if text is not None else NOTHING_IN_SCOPE


def as_text(raw: Any) -> Optional[str]:
    """Convert a scalar of the parameter server to text.

    :param raw: the value on the server, None if it is not set
    :returns: the text; None if it is not set, or is a list or a namespace
    """
    if raw is None or isinstance(raw, (dict, list)):
        return None
    data = getattr(raw, "data", None)  # base64 arrives wrapped
    return data.decode("utf-8", "replace") if isinstance(data, bytes) else str(raw)
