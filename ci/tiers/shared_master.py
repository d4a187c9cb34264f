"""Run rostest files of one package on one master: ``python3 ci tiers.shared_master --help``.

rostest starts an interpreter, a master and another interpreter for each file, 2 s of processor time
before the first test. Here the files share a master, their nodes are started once, and each test
node is forked from a process with the common imports. As with rostest, each test node is a separate
process, started by its own script, and writes its own JUnit file.

The process that forks has no threads: roslaunch and the master run in its children.
"""

import argparse
import contextlib
import importlib
import json
import os
import pathlib
import runpy
import select
import signal
import sys
import time
import traceback
from typing import Any, Callable, Dict, Iterator, List, NoReturn
from xml.sax.saxutils import quoteattr

import rosgraph
import roslaunch
import roslaunch.config
import roslaunch.node_args
import roslaunch.parent
import rosnode
import rospy

from .steps import PLACES, free_port
from .workspace import WORKSPACE

#: Modules to import before the first fork, which costs a package nothing if unused.
WARM = ("rostest", "unittest", "nodekit.testing.running", "nodekit.testing.launching")
#: Longest time until a launch file's nodes are started, or a master answers [s]: a hang guard.
START_S = 120.0
#: Time to end after a signal [s].
GRACE_S = 15.0
RUN_ID = "shared_master"


def fork(run: Callable[[], int]) -> int:
    """Run a function in a child process with a new session; its result is the exit status.

    :returns: the child's process id
    """
    sys.stdout.flush()
    sys.stderr.flush()
    pid = os.fork()
    if pid:
        return pid
    status = 1
    try:
        os.setsid()
        status = run()
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        traceback.print_exc()
    finally:
        end_child(status)


def end_child(status: int) -> NoReturn:
    """End this process as an interpreter does, without unwinding the parent's stack."""
    import atexit
    import threading

    with contextlib.suppress(Exception):
        threading._shutdown()  # type: ignore[attr-defined]
        atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def wait(pid: int, seconds: float) -> int:
    """Wait for a child to end; interrupt it, then kill it, if it takes too long.

    :returns: its exit status, negative for a signal
    :raises TimeoutError: after a child that had to be ended
    """
    deadline = time.monotonic() + seconds
    for number in (signal.SIGINT, signal.SIGKILL):
        while time.monotonic() < deadline:
            done, status = os.waitpid(pid, os.WNOHANG)
            if done:
                if number == signal.SIGKILL:
                    raise TimeoutError(f"interrupted after {seconds:g} s")
                return os.WEXITSTATUS(status) if os.WIFEXITED(status) else -os.WTERMSIG(status)
            time.sleep(0.01)
        os.killpg(pid, number)
        deadline = time.monotonic() + GRACE_S
    os.waitpid(pid, 0)
    raise TimeoutError(f"killed after {seconds:g} s")


@contextlib.contextmanager
def in_background(run: Callable[[Callable[[], None]], None]) -> Iterator[None]:
    """Run a function in a child until the end of the block.

    :param run: the function; it calls its argument when it is ready, which returns at the end of
        the block, and must then return soon
    :raises RuntimeError: if it ends before it is ready
    """
    ready, is_ready = os.pipe()
    end, at_end = os.pipe()

    def main() -> int:
        os.close(ready)
        os.close(at_end)

        def stand_by() -> None:
            os.write(is_ready, b".")
            # Until the parent closes the other end, or ends.
            while os.read(end, 1):
                continue

        run(stand_by)
        return 0

    pid = fork(main)
    os.close(is_ready)
    os.close(end)
    try:
        if not select.select([ready], [], [], START_S)[0] or not os.read(ready, 1):
            raise RuntimeError("did not start: see above")
        yield
    finally:
        os.close(ready)
        os.close(at_end)
        with contextlib.suppress(TimeoutError):
            wait(pid, START_S)


def run_master(port: int) -> Callable[[Callable[[], None]], None]:
    """Return a function that runs a master, and the rosout node, on a port."""

    def run(stand_by: Callable[[], None]) -> None:
        parent = roslaunch.parent.ROSLaunchParent(
            RUN_ID, [], is_core=True, port=port, show_summary=False
        )
        parent.start(auto_terminate=False)
        try:
            stand_by()
        finally:
            parent.shutdown()

    return run


def run_nodes(file: pathlib.Path) -> Callable[[Callable[[], None]], None]:
    """Return a function that runs the nodes of a file, and sets its parameters."""

    def run(stand_by: Callable[[], None]) -> None:
        parent = roslaunch.parent.ROSLaunchParent(RUN_ID, [str(file)], show_summary=False)
        parent.start(auto_terminate=False)
        try:
            stand_by()
        finally:
            parent.shutdown()

    return run


def run_test(test: Any, results: pathlib.Path) -> int:
    """Become the process of a test node: its arguments, its environment, its script.

    :param test: roslaunch's object for it
    :param results: the JUnit file to write
    """
    machine = roslaunch.core.local_machine()
    command = roslaunch.node_args.create_local_process_args(test, machine)
    environment = roslaunch.node_args.setup_env(test, machine, rosgraph.get_master_uri())
    command.append(f"--gtest_output=xml:{results}")
    with open(command[0], "rb") as script:
        is_python = b"python" in script.readline()
    if not is_python or test.launch_prefix:
        os.execvpe(command[0], command, environment)
    os.environ.clear()
    os.environ.update(environment)
    before = environment.get("PYTHONPATH", "").split(os.pathsep)
    sys.path[:0] = [os.path.dirname(command[0]), *(place for place in before if place)]
    sys.argv[:] = command
    # rospy has read the name and the remappings from the command line on import.
    rospy.names.reload_mappings(command)
    importlib.invalidate_caches()
    runpy.run_path(command[0], run_name="__main__")
    return 0


def reset(master: rosgraph.Master, kept: List[str]) -> None:
    """Delete the parameters of a file, and the registrations of ended nodes."""
    for name in master.getParamNames():
        if name not in kept:
            with contextlib.suppress(rosgraph.MasterError):
                master.deleteParam(name)
    gone = [node for node in rosnode.get_node_names() if node != "/rosout"]
    if gone:
        rosnode.cleanup_master_blacklist(master, gone)


def test_file(file: pathlib.Path, results: pathlib.Path) -> None:
    """Start the nodes of a file and run its tests one after the other.

    :raises RuntimeError: if a node cannot be started
    """
    config = roslaunch.config.load_config_default([str(file)], None)
    with in_background(run_nodes(file)):
        for test in config.tests:
            output = results / f"{file.stem}.{test.test_name}.xml"
            began, why = time.monotonic(), ""
            try:
                status = wait(fork(lambda: run_test(test, output)), test.time_limit)
            except TimeoutError as error:
                status, why = 1, str(error)
            if why or not output.exists():
                why = why or f"ended with status {status} and wrote no results"
                write_failure(output, test.test_name, why)
            print(
                f"{file.name}: {test.test_name} ended with {status} after "
                f"{time.monotonic() - began:.1f} s",
                flush=True,
            )


def write_failure(output: pathlib.Path, name: str, why: str) -> None:
    """Write a JUnit file with one failure."""
    output.write_text(
        f'<testsuite name={quoteattr(name)} tests="1" failures="1"><testcase '
        f'classname={quoteattr(name)} name={quoteattr(name)} time="0"><failure '
        f"message={quoteattr(why)}/></testcase></testsuite>\n"
    )


def main() -> int:
    """Run the files named on the command line.

    :returns: exit status: 0 if each test wrote its results; these say whether it passed
    """
    parser = argparse.ArgumentParser(prog="python3 ci tiers.shared_master", description=__doc__)
    parser.add_argument("--results", type=pathlib.Path, required=True, help="folder to write to")
    parser.add_argument("--test", default="", help="the name of the only test to run")
    parser.add_argument("files", type=pathlib.Path, nargs="+", metavar="FILE.test")
    options = parser.parse_args()
    for module in WARM:
        importlib.import_module(module)
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://localhost:{port}"
    if options.test:
        os.environ["NODEKIT_TESTS_ONLY"] = options.test
    places: Dict[str, float] = {}
    options.results.mkdir(parents=True, exist_ok=True)
    with in_background(run_master(port)):
        master = rosgraph.Master("/shared_master")
        kept = master.getParamNames()
        # The settings of roscore's own file are set, and each reading of it starts two commands.
        roslaunch.config.load_roscore = lambda *_, **__: None
        for file in options.files:
            began = time.monotonic()
            try:
                test_file(file.resolve(), options.results)
            except Exception as error:
                traceback.print_exc()
                write_failure(options.results / f"{file.stem}.xml", file.stem, str(error))
            reset(master, kept)
            places[str(file.resolve().relative_to(WORKSPACE))] = time.monotonic() - began
    (options.results / PLACES).write_text(json.dumps(places), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
