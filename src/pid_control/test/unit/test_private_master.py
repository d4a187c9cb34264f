"""Tests of a judgement's own master, without its process."""

import os
import tempfile
from typing import List
from unittest import mock

import pytest

from pid_control.programs import private_master


@pytest.mark.parametrize("fails", [True, False])
def test_private_master_leaves_nothing_and_hides_the_user_environment(
    fails: bool, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    for name in ("ROS_IP", "ROS_NAMESPACE", "ROS_HOSTNAME", "ROS_HOME", "ROS_LOG_DIR"):
        monkeypatch.setenv(name, "of_the_user")
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:1")
    folders: List[str] = []
    make = tempfile.mkdtemp

    def make_folder(prefix: str) -> str:
        assert prefix == "judge-"
        folders.append(make(prefix=prefix))
        return folders[-1]

    monkeypatch.setattr("tempfile.mkdtemp", make_folder)
    process = mock.Mock(uri="http://localhost:2")
    start = mock.Mock(return_value=process)
    monkeypatch.setattr(private_master, "MasterProcess", start)
    master = mock.Mock()
    master.return_value.getPid.side_effect = [OSError] if fails else [7, 7, OSError]
    monkeypatch.setattr("rosgraph.Master", master)
    if fails:
        with pytest.raises(OSError):
            private_master.PrivateMaster()
    else:
        private = private_master.PrivateMaster()
        assert private.pid == 7 and os.environ["ROS_MASTER_URI"] == process.uri
        assert not {"ROS_IP", "ROS_NAMESPACE"} & set(os.environ)
        [folder] = folders
        assert private.environment == {
            "ROS_MASTER_URI": process.uri,
            "ROS_HOSTNAME": "localhost",
            "ROS_HOME": folder,
            "ROS_LOG_DIR": f"{folder}/log",
        }
        assert private.environment.items() <= os.environ.items() and private.folder == folder
        assert private.is_running() and not private.is_running()  # it has ended
        assert master.call_args_list == [mock.call("/judge", process.uri)] * 3
        private.close()
    start.assert_called_once_with(start_new_session=True)
    process.kill.assert_called_once_with()
    assert not os.path.exists(folders[0])
