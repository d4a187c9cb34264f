"""A master for one judgement, which no other node knows."""

import os
import shutil
import tempfile
from typing import Dict, Optional

from nodekit.testing.processes import Master
from pid_control.runner.deferred_signals import deferred_signals


class PrivateMaster:
    """A master on a free port of this machine alone, and a folder for what its nodes write.

    ``environment`` has the variables for its nodes. They are set in this process as well, before it
    becomes one of them.
    """

    def __init__(self) -> None:
        self._folder = tempfile.mkdtemp(prefix="judge-")
        for name in ("ROS_IP", "ROS_NAMESPACE"):
            os.environ.pop(name, None)
        own = {"ROS_HOSTNAME": "localhost", "ROS_HOME": self._folder}
        own["ROS_LOG_DIR"] = os.path.join(self._folder, "log")
        os.environ.update(own)
        self._master: Optional[Master] = None
        try:
            with deferred_signals():
                # In a session of its own: Ctrl-C would end what is being waited for here.
                self._master = master = Master(start_new_session=True)
        except BaseException:
            self.close()
            raise
        os.environ["ROS_MASTER_URI"] = master.uri
        self.environment: Dict[str, str] = {**own, "ROS_MASTER_URI": master.uri}

    def close(self) -> None:
        """End it, and remove what was written."""
        if self._master is not None:
            self._master.kill()
        shutil.rmtree(self._folder, ignore_errors=True)
