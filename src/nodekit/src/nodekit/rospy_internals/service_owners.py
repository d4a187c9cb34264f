"""Whose a service is: the master knows one node for each name, the latest that registered it."""

from typing import Any, Callable, Dict, List, Mapping, Sequence, Tuple

import rospy

#: Sends calls (method, argument, ...) to the master and returns its answers (code, message,
#: value); raises ConnectionError where it does not answer in time.
Request = Callable[[List[Tuple[Any, ...]]], List[Any]]
#: Most services that a line of the log names.
_NAMED = 5


def with_owners(names: Sequence[str], request: Request) -> str:
    """Return services with the nodes that offer them, as text.

    :param names: of the services
    :param request: asks the master
    :raises ConnectionError: if that does
    """
    state = request([("getSystemState",)])
    nodes = {name: ", ".join(found) for name, found in state[0][2][2]} if state else {}
    texts = [f"{name} ({nodes.get(name, 'unknown')})" for name in names[:_NAMED]]
    more = len(names) - _NAMED
    return ", ".join(texts) + (f" and {more} more" if more > 0 else "")


def tell_of_others(services: Mapping[str, str], request: Request) -> None:
    """Warn of services that are just being registered and are another node's until then.

    :param services: names, each with this process's URI
    :param request: asks the master
    :raises ConnectionError: if that does
    """
    answers = request([("lookupService", name) for name in services]) if services else []
    owners: Dict[str, str] = {n: uri for n, (code, _, uri) in zip(services, answers) if code == 1}
    others = [name for name, uri in owners.items() if uri != services[name]]
    if others:
        text = "already offered, from now on this node is called in place of the other: service %s"
        rospy.logwarn(text, with_owners(others, request))
