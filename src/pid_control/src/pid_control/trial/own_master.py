"""A master for one judgement, which no other node knows."""

import os
import shutil
import tempfile
from typing import Dict

from nodekit.testing.processes import Master


class OwnMaster:
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
        try:
            self._master = Master()
        except BaseException:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise
        os.environ["ROS_MASTER_URI"] = self._master.uri
        self.environment: Dict[str, str] = {**own, "ROS_MASTER_URI": self._master.uri}

    def close(self) -> None:
        """End it, and remove what was written."""
        self._master.kill()
        shutil.rmtree(self._folder, ignore_errors=True)
