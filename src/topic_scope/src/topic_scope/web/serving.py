"""What serves pages of a scope, whatever it shows."""

import os
import socket
import webbrowser
from typing import List

import rospkg
import tornado.httpserver

from topic_scope.protocol.options import Options
from topic_scope.web import hosts, web


def serve(options: Options, sockets: List[socket.socket], front: web.Front) -> None:
    """Serve pages from now on, in the loop of the thread that calls this.

    :param options: the command line
    :param sockets: where to serve
    :param front: what pages show
    """
    # roslib asks the program rospack, which a Ctrl-C at that moment ends as well.
    folder = os.path.join(rospkg.RosPack().get_path("topic_scope"), "www")
    names = hosts.names_of(socket.gethostname(), socket.getfqdn(), options.address)
    application = web.application(front, folder, names)
    server = tornado.httpserver.HTTPServer(application, max_header_size=16384, max_body_size=4096)
    server.add_sockets(sockets)


def open_browser(url: str) -> None:
    """Open a page, where there is a display and a browser; waits for it."""
    # Without a display the module would take one that runs in the terminal.
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(url)
