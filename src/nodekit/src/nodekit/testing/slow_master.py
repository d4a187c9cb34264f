"""A master that can be told to keep a node waiting in the middle of one call."""

import socketserver
import threading
from typing import Any, List
from xmlrpc.client import ServerProxy
from xmlrpc.server import SimpleXMLRPCServer


class _Server(socketserver.ThreadingMixIn, SimpleXMLRPCServer):
    daemon_threads = True


class SlowMaster:
    """Hands every call on to a real master, one of them only when it is told to.

    :param master_uri: URI of the real master
    :param method: name of the call that has to wait, e.g. registerService
    :param ending: how one of its arguments ends, e.g. /set_logger_level

    :ivar asked: how many calls have come
    :ivar calls: the names of all calls that have been answered
    """

    def __init__(self, master_uri: str, method: str, ending: str) -> None:
        self._master_uri = master_uri
        self._method = method
        self._ending = ending
        self.asked = 0
        self.calls: List[str] = []
        self.reached = threading.Event()
        self.go_on = threading.Event()
        self._server = _Server(("localhost", 0), logRequests=False, allow_none=True)
        self._server.register_instance(self)
        self._server.register_multicall_functions()
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    @property
    def uri(self) -> str:
        """The URI for ROS_MASTER_URI."""
        return f"http://localhost:{self._server.server_address[1]}"

    def close(self) -> None:
        """Let everything go on, and stop answering."""
        self.go_on.set()
        self._server.shutdown()
        self._server.server_close()

    def _dispatch(self, method: str, arguments: Any) -> Any:
        self.asked += 1
        texts = [argument for argument in arguments if isinstance(argument, str)]
        if method == self._method and any(text.endswith(self._ending) for text in texts):
            self.reached.set()
            self.go_on.wait()
        answer = getattr(ServerProxy(self._master_uri), method)(*arguments)
        self.calls.append(method)
        return answer
