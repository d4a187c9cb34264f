"""Run Python programs in forks of a process that has already imported what they import.

Starting an interpreter and importing rospy takes longer than most commands themselves. Here both
are done once. Each program is still a process of its own: the main thread of the fork runs the
file, with its own arguments, directory, environment, output and signals. It ends as Python ends,
apart from the destruction of all objects, which takes 20 times as long as the fork. The programs
that roslaunch starts are such forks as well, if they are Python files without a launch-prefix.
"""

import atexit
import contextlib
import gc
import importlib
import json
import os
import re
import runpy
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Tuple

import rospkg
from pages import WORKSPACE, environment_of_reader

#: What the commands of ROS and the nodes import. No module of the workspace that a page runs, apart
#: from nodekit.
PRELOADED = (
    "genpy.dynamic",
    "geometry_msgs.msg",
    "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_svg",
    "matplotlib.figure",
    "nav_msgs.msg",
    "nodekit",
    "numpy",
    "pkg_resources",
    "rosbag",
    "roscpp.srv",
    "rosgraph_msgs.msg",
    "roslaunch",
    "rosmaster.main",
    "rosmsg",
    "rosnode",
    "rosparam",
    "rosservice",
    "rostopic",
    "scipy.optimize",
    "sensor_msgs.msg",
    "std_msgs.msg",
    "std_srvs.srv",
    "tornado.web",
    "tornado.websocket",
)
#: Commands that roslaunch takes parameters from at each start.
OF_EACH_START = (["rosversion", "roslaunch"], ["rosversion", "-d"])
#: How long the server may take to import all that on a busy machine [s].
_START_TIMEOUT_S = 100.0
#: The first line of a Python file.
_PYTHON = re.compile(rb"#!\s*\S*(/env )?\S*python3?\s*\n")
_LENGTH = struct.Struct("!I")
#: A message of the server's side: what it tells, and that.
_NOTICE = struct.Struct("!ci")
_PID, _STATUS = b"p", b"s"


class Program(NamedTuple):
    """A Python program to run.

    :param argv: path of the file, and its arguments
    :param folder: working directory
    :param environment: all its variables
    :param output: path of the file or terminal that standard output is appended to
    :param errors: the same for standard error
    """

    argv: List[str]
    folder: str
    environment: Dict[str, str]
    output: str
    errors: str


class WarmProcess:
    """A running program, with the methods of ``subprocess.Popen`` that the tests need."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._status: Optional[int] = None
        self._lock = threading.Lock()
        kind, self.pid = _NOTICE.unpack(_receive(connection, _NOTICE.size))
        if kind != _PID:
            raise OSError(f"the program could not be started: status {self.pid}")

    def poll(self) -> Optional[int]:
        """Return the exit status, None while the program runs."""
        return self._look(0.0)

    def wait(self, timeout: Optional[float] = None) -> int:
        """Wait for the end.

        :raises subprocess.TimeoutExpired: if the program still runs after the timeout [s]
        """
        status = self._look(timeout)
        if status is None:
            raise subprocess.TimeoutExpired(str(self.pid), timeout or 0.0)
        return status

    def _look(self, timeout: Optional[float]) -> Optional[int]:
        with self._lock:
            if self._status is None and select.select([self._connection], [], [], timeout)[0]:
                _, self._status = _NOTICE.unpack(_receive(self._connection, _NOTICE.size))
                self._connection.close()
            return self._status


def python_file(words: List[str], environment: Dict[str, str]) -> List[str]:
    """Return the path of the Python file that a command runs, and its arguments.

    :returns: nothing where the command runs another program
    """
    path = shutil.which(words[0], path=environment["PATH"]) if words else None
    if path is None:
        return []
    with open(path, "rb") as file:
        return [path, *words[1:]] if _PYTHON.match(file.readline(200)) else []


class WarmPython(NamedTuple):
    """A client of the server; any process may have one.

    :param path: of the server's socket
    """

    path: str

    def start(self, program: Program) -> WarmProcess:
        """Start a program; it leads a session and a process group of its own."""
        text = json.dumps(program).encode()
        connection = socket.socket(socket.AF_UNIX)
        connection.connect(self.path)
        connection.sendall(_LENGTH.pack(len(text)) + text)
        return WarmProcess(connection)


@contextlib.contextmanager
def warm_python() -> Iterator[WarmPython]:
    """Run a server, which ends at the latest with this process; the programs go on."""
    with tempfile.TemporaryDirectory() as folder:
        client = WarmPython(os.path.join(folder, "socket"))
        with subprocess.Popen(
            [sys.executable, __file__, client.path],
            env=environment_of_reader(),
            stdin=subprocess.PIPE,  # its end is the server's
            stdout=subprocess.PIPE,
            start_new_session=True,
        ) as server:
            assert server.stdin is not None and server.stdout is not None
            if not select.select([server.stdout], [], [], _START_TIMEOUT_S)[0]:
                server.kill()
                raise TimeoutError("the server of warm processes does not start")
            if not server.stdout.read(1):
                raise OSError("the server of warm processes has ended")
            try:
                yield client
            finally:
                server.stdin.close()


def _receive(connection: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count:
        more = connection.recv(count - len(data))
        if not more:
            raise ConnectionError("the server of warm processes has gone")
        data += more
    return data


def _serve(path: str) -> Optional[Program]:
    """Fork for each connection; report the status of the fork when it has ended.

    Until the client has read the status, the fork keeps its process id, as with ``Popen``.

    :param path: of the socket
    :returns: in a fork, what it has to run; None at the end of standard input
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    woken, waking = os.pipe()
    for pipe in (woken, waking):
        os.set_blocking(pipe, False)
    signal.set_wakeup_fd(waking, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    running: Dict[socket.socket, int] = {}
    ended: Dict[socket.socket, int] = {}
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen(64)
        os.write(1, b".")
        while True:
            ready = select.select([0, woken, listener, *ended], [], [])[0]
            if 0 in ready:
                return None
            if woken in ready:
                os.read(woken, 4096)
                for connection in list(running):
                    if _report(connection, running[connection]):
                        ended[connection] = running.pop(connection)
            for connection in [each for each in ended if each in ready]:
                os.waitpid(ended.pop(connection), 0)
                connection.close()
            if listener in ready:
                connection = listener.accept()[0]
                try:
                    (length,) = _LENGTH.unpack(_receive(connection, _LENGTH.size))
                    program = Program(*json.loads(_receive(connection, length)))
                except ConnectionError:  # the client has ended
                    connection.close()
                    continue
                pid = os.fork()
                if pid:
                    running[connection] = pid
                    continue
                signal.set_wakeup_fd(-1)
                for pipe in (woken, waking):
                    os.close(pipe)
                for other in (*running, *ended):
                    other.close()
                _become(program)
                with connection:
                    connection.sendall(_NOTICE.pack(_PID, os.getpid()))
                return program


def _report(connection: socket.socket, pid: int) -> bool:
    """Send the exit status of a fork to its client; return whether the fork has ended."""
    end = os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT | os.WNOHANG)
    if end is None:
        return False
    status = end.si_status if end.si_code == os.CLD_EXITED else -end.si_status
    with contextlib.suppress(OSError):  # the client has ended
        connection.sendall(_NOTICE.pack(_STATUS, status))
    return True


def _become(program: Program) -> None:
    """Give this process the surroundings of a program that was just started."""
    os.setsid()
    for number in (signal.SIGCHLD, signal.SIGINT):
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.chdir(program.folder)
    os.environ.clear()
    os.environ.update(program.environment)
    null = os.open(os.devnull, os.O_RDONLY)
    flags = os.O_WRONLY | os.O_APPEND | os.O_NOCTTY
    output, errors = os.open(program.output, flags), os.open(program.errors, flags)
    for place, opened in enumerate((null, output, errors)):
        os.dup2(opened, place)
        os.close(opened)
    sys.stdout.reconfigure(line_buffering=os.isatty(1))  # type: ignore[attr-defined]
    sys.argv[:] = program.argv
    sys.path[0] = str(Path(program.argv[0]).resolve().parent)
    # Alone among the modules above it reads arguments and environment when it is imported.
    importlib.reload(sys.modules["rospy.names"])


def _remember_packages() -> None:
    """Search the folders with packages once for all forks; roslaunch does so for each node."""
    rospack: Any = rospkg.rospack
    search: Callable[[str, str, Any], List[str]] = rospack.list_by_path
    known: Dict[Tuple[str, str], Dict[str, str]] = {}
    for path in rospkg.get_ros_paths():
        search(rospkg.MANIFEST_FILE, path, known.setdefault((rospkg.MANIFEST_FILE, path), {}))

    def list_by_path(manifest: str, path: str, cache: Any) -> List[str]:
        if (manifest, path) not in known:
            return search(manifest, path, cache)
        cache.update(known[manifest, path])
        return list(known[manifest, path])

    rospack.list_by_path = list_by_path
    catkin: Any = importlib.import_module("catkin.find_in_workspaces")
    parse, sources = catkin.find_packages, str(WORKSPACE / "src")
    parsed = parse(sources)
    catkin.find_packages = lambda path: parsed if path == sources else parse(path)


def _main() -> None:
    for name in PRELOADED:
        importlib.import_module(name)
    _remember_packages()
    answers = {tuple(words): subprocess.check_output(words) for words in OF_EACH_START}
    nodekit = sys.modules["nodekit"]
    for name in nodekit.__all__:  # which it imports when it is asked for them
        getattr(nodekit, name)
    assert threading.active_count() == 1, "a fork would be without the other threads"
    gc.collect()
    gc.freeze()
    client = WarmPython(sys.argv[1])
    program = _serve(client.path)
    if program is not None:
        if Path(program.argv[0]).name in ("roscore", "roslaunch"):
            subprocess.Popen = _Popen(client, answers)  # type: ignore
        _end(_run(program))


class _Popen:
    """``subprocess.Popen`` as roslaunch calls it: for nodes, and for what commands print.

    :param python: starts those that are Python files
    :param answers: what some commands print
    """

    def __init__(self, python: WarmPython, answers: Dict[Tuple[str, ...], bytes]) -> None:
        self._python, self._answers = python, answers
        self._cold = subprocess.Popen

    def __call__(
        self,
        args: Any,
        cwd: Optional[str] = None,
        stdout: Any = None,
        stderr: Any = None,
        env: Optional[Dict[str, str]] = None,
        **more: Any,
    ) -> Any:
        if isinstance(args, list) and tuple(args) in self._answers:
            return _Answer(self._answers[tuple(args)])
        variables = dict(os.environ if env is None else env)
        argv = python_file(args, variables) if isinstance(args, list) else []
        if not argv or isinstance(stderr, int) or set(more) - {"close_fds", "preexec_fn"}:
            return self._cold(args, cwd=cwd, stdout=stdout, stderr=stderr, env=env, **more)
        if stdout == subprocess.PIPE:
            reading, writing = os.pipe()
        else:
            writing = stdout.fileno() if stdout else 1
        output, errors = (
            f"/proc/{os.getpid()}/fd/{number}"
            for number in (writing, stderr.fileno() if stderr else 2)
        )
        process = self._python.start(Program(argv, cwd or os.getcwd(), variables, output, errors))
        if stdout != subprocess.PIPE:
            return process
        os.close(writing)
        return _Printing(process, reading)


class _Answer(NamedTuple):
    """A command that has printed something, as :class:`_Printing`."""

    text: bytes
    returncode: int = 0

    def communicate(self) -> Tuple[bytes, None]:
        """Return what it has printed."""
        return self.text, None


class _Printing:
    """A command that prints a value, with the parts of ``Popen`` that roslaunch uses then."""

    def __init__(self, process: WarmProcess, output: int) -> None:
        self._process, self._output = process, output
        self.returncode: Optional[int] = None

    def communicate(self) -> Tuple[bytes, None]:
        """Wait for the end; return what it has printed."""
        with open(self._output, "rb") as output:
            text = output.read()
        self.returncode = self._process.wait()
        return text, None


def _run(program: Program) -> object:
    """Run a program in this process; return what it hands to ``sys.exit``, -2 for Ctrl-C."""
    try:
        runpy.run_path(program.argv[0], run_name="__main__")
    except SystemExit as end:
        return end.code
    except KeyboardInterrupt:
        sys.excepthook(*sys.exc_info())
        return -signal.SIGINT
    except BaseException:
        sys.excepthook(*sys.exc_info())
        return 1
    return 0


def _end(code: object) -> None:
    """End this process as Python does: wait for threads, call the functions of atexit, flush."""
    if code is not None and not isinstance(code, int):
        print(code, file=sys.stderr)
        code = 1
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            code = 120  # as Python's own
    if code == -signal.SIGINT:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGINT)
    os._exit((code or 0) & 0xFF)


if __name__ == "__main__":
    _main()
