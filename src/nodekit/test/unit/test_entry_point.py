"""Tests of the settings of a node's process before its imports."""

import subprocess
import sys

import pytest

IGNORE_INTERRUPT = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
RUN = "import sys; from nodekit.entry_point import main; main('%s')"


def run_main(tmp_path, text, before=""):
    """Run the entry point on a module with this text; return the finished process.

    :param before: lines that the program begins with
    """
    (tmp_path / "some_node.py").write_text(text)
    return subprocess.run(
        [sys.executable, "-c", f"{before}\n{RUN}" % "some_node"],
        cwd=str(tmp_path),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def assert_ends_well(done):
    """Compare with the status that the nodes here end with."""
    assert (done.returncode, done.stderr) == (5, b"")


def test_messages_are_imported_without_numpy(tmp_path):
    text = (
        "import genpy.message, rospy, sys\n"
        "from std_msgs.msg import Float32MultiArray\n"
        "def main():\n"
        "    assert getattr(genpy.message, 'np', None) is None\n"
        "    assert 'numpy' not in sys.modules\n"
        "    assert genpy.message.check_type('data', 'float32', 1.5) is None\n"
        "    sys.exit(5)\n"
    )
    assert_ends_well(run_main(tmp_path, text))


@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_a_node_without_an_output_does_without(tmp_path, closed):
    (tmp_path / "some_node.py").write_text(
        "import logging, sys\n"
        "from nodekit.rospy_internals.log_handlers import patch_logs\n"
        "from rosgraph.roslogging import RosStreamHandler\n"
        "def main():\n"
        "    patch_logs()\n"
        "    logging.getLogger().addHandler(RosStreamHandler())\n"
        "    logging.getLogger().setLevel('INFO')\n"
        "    logging.getLogger().info('lost')\n"
        "    logging.getLogger().error('lost')\n"
        "    sys.exit(5)\n"
    )
    command = ["sh", "-c", f'exec "$@" {closed}', "sh", sys.executable, "-c", RUN % "some_node"]
    done = subprocess.run(command, cwd=str(tmp_path))
    assert done.returncode == 5


def test_an_interrupt_ends_the_process_whatever_an_import_makes_of_it(tmp_path):
    text = (
        "import os, signal, sys, time\n"
        "try:\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "    time.sleep(10.0)\n"
        "except BaseException:\n"
        "    pass\n"
        "def main():\n"
        "    sys.exit(5)\n"
    )
    done = run_main(tmp_path, text)
    assert (done.returncode, done.stderr) == (0, b"")
    assert_ends_well(run_main(tmp_path, text.replace("10.0", "0.0"), IGNORE_INTERRUPT))


@pytest.mark.parametrize("where", ["", "    "])
def test_node_that_imports_numpy_gets_it(tmp_path, where):
    lines = ["import numpy", "import rospy, rospy.numpy_msg", "import numpy.linalg"]
    text = (
        "import genpy.message, sys\n"
        "%s\n"
        "%s\n"
        "    assert numpy.zeros(3).sum() == 0.0 and numpy.linalg.norm([3.0, 4.0]) == 5.0\n"
        "    assert numpy is sys.modules['numpy']\n"
        "    assert numpy.__spec__.origin == numpy.__file__\n"
        "    assert getattr(genpy.message, 'np', None) is None\n"
        "    sys.exit(5)\n"
    )
    at = "def main():\n" + "\n".join(where + line for line in lines)
    if not where:
        at = "\n".join([*lines, "def main():"])
    assert_ends_well(run_main(tmp_path, text % ("", at)))


def test_numpy_that_is_loaded_already_stays(tmp_path):
    text = (
        "import genpy.message, numpy, sys\n"
        "def main():\n"
        "    assert numpy is sys.loaded_before is sys.modules['numpy']\n"
        "    assert getattr(genpy.message, 'np', numpy) is numpy\n"
        "    sys.exit(5)\n"
    )
    before = "import numpy, sys\nsys.loaded_before = numpy"
    assert_ends_well(run_main(tmp_path, text, before))


def test_missing_numpy_raises_import_error(tmp_path):
    # As if it were not installed: that is not to be mended.
    text = (
        "import sys\n"
        "def main():\n"
        "    try:\n"
        "        import numpy\n"
        "    except ModuleNotFoundError:\n"
        "        sys.exit(5)\n"
    )
    before = "import sys\nsys.modules['numpy'] = None"
    assert_ends_well(run_main(tmp_path, text, before))


def test_interrupt_during_the_imports_exits_cleanly(tmp_path):
    done = run_main(tmp_path, "raise KeyboardInterrupt\n")
    assert (done.returncode, done.stderr) == (0, b"")


def test_sigterm_after_an_interrupt_during_the_imports_changes_no_status(tmp_path):
    text = (
        "import atexit, os, signal\n"
        "atexit.register(os.kill, os.getpid(), signal.SIGTERM)\n"
        "raise KeyboardInterrupt\n"
    )
    done = run_main(tmp_path, text)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize(
    "status, code, errors", [(3, 3, b""), (None, 0, b""), (True, 1, b""), ("why", 1, b"why\n")]
)
def test_end_calls_the_exit_handlers_and_clears_no_module(tmp_path, status, code, errors):
    text = (
        "import atexit, threading, time\n"
        "from nodekit.entry_point import end\n"
        "class Cleared:\n"
        "    def __del__(self, print=print):\n"
        "        print('cleared')\n"
        "held = Cleared()\n"
        "def main():\n"
        "    atexit.register(print, 'second', end=' ')\n"
        "    atexit.register(print, 'first', end=' ')\n"
        "    threading.Thread(target=time.sleep, args=(60.0,), daemon=True).start()\n"
        f"    end({status!r})\n"
    )
    done = run_main(tmp_path, text, "import atexit; atexit.register(print, 'last', end='')")
    assert (done.returncode, done.stdout, done.stderr) == (code, b"first second last", errors)


def test_an_exit_handler_that_fails_is_printed_and_keeps_the_status(tmp_path):
    text = (
        "import atexit\n"
        "from nodekit.entry_point import end\n"
        "def main():\n"
        "    atexit.register(print, 'last')\n"
        "    atexit.register(divmod, 1, 0)\n"
        "    end(3)\n"
    )
    done = run_main(tmp_path, text)
    assert (done.returncode, done.stdout) == (3, b"last\n")
    assert b"ZeroDivisionError" in done.stderr


def test_search_for_files_is_imported_when_it_is_needed(tmp_path):
    text = (
        "import roslib.packages, sys\n"
        "def main():\n"
        "    assert 'pyparsing' not in sys.modules\n"
        "    assert 'catkin.find_in_workspaces' not in sys.modules\n"
        "    for _ in range(2):\n"
        "        files = roslib.packages.catkin_find(project='nodekit', path='package.xml')\n"
        "    sys.exit(5 if files and 'pyparsing' in sys.modules else 6)\n"
    )
    assert_ends_well(run_main(tmp_path, text))


def test_node_that_imports_catkins_search_gets_it(tmp_path):
    text = (
        "import catkin.find_in_workspaces, catkin.workspace, sys\n"
        "from os.path import dirname, isfile\n"
        "from catkin import find_in_workspaces as module\n"
        "def main():\n"
        "    assert module is catkin.find_in_workspaces\n"
        "    assert module is sys.modules['catkin.find_in_workspaces']\n"
        "    assert dirname(module.__file__) == dirname(catkin.workspace.__file__)\n"
        "    found = module.find_in_workspaces(['share'], project='nodekit', path='package.xml')\n"
        "    assert found and isfile(found[0])\n"
        "    sys.exit(5)\n"
    )
    assert_ends_well(run_main(tmp_path, text))


def test_catkins_search_that_is_loaded_already_stays(tmp_path):
    text = (
        "import catkin.find_in_workspaces as module, roslib.packages, sys\n"
        "def main():\n"
        "    assert module is sys.loaded_before\n"
        "    assert roslib.packages.catkin_find is module.find_in_workspaces\n"
        "    sys.exit(5)\n"
    )
    before = "import catkin.find_in_workspaces, sys\nsys.loaded_before = catkin.find_in_workspaces"
    assert_ends_well(run_main(tmp_path, text, before))
