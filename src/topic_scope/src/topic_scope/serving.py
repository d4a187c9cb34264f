"""What serves pages of a scope, whatever it shows."""

import os
import socket
import webbrowser
from typing import List

import rospkg
import tornado.httpserver

from topic_scope import web
from topic_scope.options import Options
from topic_scope.origin import Origin
from topic_scope.server import Server


def serve(options: Options, sockets: List[socket.socket], origin: Origin) -> None:
    """Serve pages from now on, in the loop of the thread that calls this.

    :param options: the command line
    :param sockets: where to serve
    :param origin: what pages show
    """
    # roslib asks the program rospack, which a Ctrl-C at that moment ends as well.
    folder = os.path.join(rospkg.RosPack().get_path("topic_scope"), "www")
    names = ["localhost", options.address, socket.gethostname(), socket.getfqdn()]
    application = web.application(Server(options, origin), folder, [name.lower() for name in names])
    server = tornado.httpserver.HTTPServer(application, max_header_size=16384, max_body_size=4096)
    server.add_sockets(sockets)


def open_browser(url: str) -> None:
    """Open a page, where there is a display and a browser; waits for it."""
    # Without a display the module would take one that runs in the terminal.
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(url)
