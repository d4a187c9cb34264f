"""Context manager for commands: exits with one line if the master or the node does not respond."""

import contextlib
import sys
from typing import Iterator

from nodekit.master import MasterUnreachable
from nodekit.node.clients import CallError


@contextlib.contextmanager
def exit_on_error(command: str, node: str) -> Iterator[None]:
    """End a command if the master or the node does not respond, and on Ctrl-C.

    :param command: name of the command
    :param node: name of the node
    """
    try:
        yield
    except MasterUnreachable as error:
        sys.exit(f"{command}: no master at {error}")
    except CallError as error:
        sys.exit(f"{command}: {node} does not answer: {error}")
    except KeyboardInterrupt:
        sys.exit(130)  # a shell's status after Ctrl-C
