"""The last lines of a process."""

import signal
import sys
from typing import NoReturn


def end(status: object) -> NoReturn:
    """End the process with a status that no further signal changes.

    Python gives up its handlers before it has ended, so that a SIGTERM soon after a SIGINT would
    kill it; what is ignored stays so. Called by the main thread.

    :param status: as for ``sys.exit``
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    sys.exit(status)  # type: ignore[arg-type]
