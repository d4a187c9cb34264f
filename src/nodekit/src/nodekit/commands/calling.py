"""How commands end where somebody does not answer."""

import contextlib
import sys
from typing import Iterator

from nodekit.master import MasterUnreachable
from nodekit.node.clients import CallError


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
