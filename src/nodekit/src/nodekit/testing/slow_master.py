"""Proxy of a master that holds one call of a node until it is released."""

import socketserver
import threading
from typing import Any, List
from xmlrpc.client import ServerProxy
from xmlrpc.server import SimpleXMLRPCServer


class _Server(socketserver.ThreadingMixIn, SimpleXMLRPCServer):
    daemon_threads = True


class SlowMaster:
    """Proxy that forwards each call to a real master, but holds one until :attr:`go_on` is set.

    :param master_uri: URI of the real master
    :param method: name of the call to hold, e.g. registerService
    :param ending: suffix of one of its arguments, e.g. /set_logger_level

    :ivar asked: number of calls received
    :ivar calls: names of the calls that were answered
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
        """Release the held call, and close the server."""
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
