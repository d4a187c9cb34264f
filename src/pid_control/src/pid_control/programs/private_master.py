"""ROS master of one judgement on a free port, with a folder for the files of its nodes."""

import os
import shutil
import tempfile
from typing import Dict, Optional

import rosgraph

from nodekit.master_process import MasterProcess
from pid_control.programs.deferred_signals import deferred_signals


class PrivateMaster:
    """Master on a free port of this machine, with a folder for the files of its nodes.

    ``environment`` holds the environment variables of its nodes; they are set in this process too,
    before it becomes a node. ``pid`` is its process, ``folder`` the folder.
    """

    def __init__(self) -> None:
        self.folder = tempfile.mkdtemp(prefix="judge-")
        for name in ("ROS_IP", "ROS_NAMESPACE"):
            os.environ.pop(name, None)
        own = {"ROS_HOSTNAME": "localhost", "ROS_HOME": self.folder}
        own["ROS_LOG_DIR"] = os.path.join(self.folder, "log")
        os.environ.update(own)
        self._master: Optional[MasterProcess] = None
        try:
            with deferred_signals():
                # In a new session: Ctrl-C would end the master while this waits for it.
                self._master = master = MasterProcess(start_new_session=True)
            self.pid = int(rosgraph.Master("/judge", master.uri).getPid())
        except BaseException:
            self.close()
            raise
        os.environ["ROS_MASTER_URI"] = master.uri
        self.environment: Dict[str, str] = {**own, "ROS_MASTER_URI": master.uri}

    def is_running(self) -> bool:
        """Return True if the master answers."""
        try:
            return int(rosgraph.Master("/judge", self.environment["ROS_MASTER_URI"]).getPid()) > 0
        except OSError:
            return False

    def close(self) -> None:
        """Kill the master, and remove the folder."""
        if self._master is not None:
            self._master.kill()
        shutil.rmtree(self.folder, ignore_errors=True)
