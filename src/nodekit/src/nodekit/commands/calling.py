"""Call services of nodes that may not answer."""

import contextlib
import difflib
import sys
from typing import Any, Iterator, List

import rosgraph

from nodekit.groups.groups import Outside
from nodekit.master import MasterClient, MasterUnreachable
from nodekit.node.callbacks import Callback
from nodekit.node.clients import CallFuture, Client
from nodekit.node.server import CallError

#: Longest wait for an answer, s.
TIMEOUT_S = 2.0


def ask(service: str, kind: Any, *arguments: Any, timeout: float = TIMEOUT_S) -> CallFuture:
    """Call a service, not from a node's class.

    :param service: global name of the service
    :param kind: its type
    :param arguments: of the request
    :param timeout: longest time to the answer, s
    :returns: the answer, which comes later
    """
    client = Client(service, kind, Callback(Outside(), lambda function, call: None, service))
    return client.call_async(kind._request_class(*arguments), timeout)


def master(caller: str) -> MasterClient:
    """Return a client of the master for a command.

    :param caller: name of the command
    """
    return MasterClient(rosgraph.get_master_uri(), "/" + caller, "")


@contextlib.contextmanager
def ending_with_a_sentence(command: str, node: str) -> Iterator[None]:
    """End a command where somebody does not answer, and at Ctrl-C; never with status 0.

    :param command: its name
    :param node: who is asked
    """
    try:
        yield
    except MasterUnreachable as error:
        sys.exit(f"{command}: no master at {error}")
    except CallError as error:
        sys.exit(f"{command}: {node} does not answer: {error}")
    except KeyboardInterrupt:
        sys.exit(130)  # as a shell puts it


def owners(client: MasterClient, service: str, namespace: str = "/") -> List[str]:
    """List the namespaces at or below one where a service is offered.

    :param client: asks the master
    :param service: base name of the service
    :param namespace: global name
    :returns: global names, sorted
    :raises MasterUnreachable: if the master does not answer
    """
    prefix, suffix = namespace.rstrip("/") + "/", "/" + service
    names = [name for name, _ in client.system_state().services if name.endswith(suffix)]
    found = [name[: -len(suffix)] for name in names]
    return sorted(owner for owner in found if (owner + "/").startswith(prefix))


def say_what_there_is(client: MasterClient, service: str, namespace: str, problem: str) -> None:
    """Tell the user that nobody offers a service there, and who does.

    :param problem: a sentence that says the first
    :raises MasterUnreachable: if the master does not answer
    """
    everyone = owners(client, service)
    near = difflib.get_close_matches(namespace.rstrip("/"), everyone, n=1) or everyone
    hint = f"there is {', '.join(near)}" if near else "no such node is running"
    print(f"{problem}; {hint}", file=sys.stderr)
