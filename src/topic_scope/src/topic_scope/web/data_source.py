"""What a scope shows: the graph of a master, or a bag; and how it speaks with the server."""

from typing import Any, Dict, List, Mapping, Protocol

from topic_scope.messages.layouts import Layouts
from topic_scope.page.state import Page
from topic_scope.protocol.requests import Handler
from topic_scope.sampling.message_source import MessageSource


class Pages(Protocol):
    """The server of all pages, as an origin sees it.

    All methods belong to the thread of the web.
    """

    def pages(self) -> List[Page]:
        """Return the pages that are open."""

    def send_to_pages(self, message: Dict[str, Any], *about: str) -> None:
        """Tell all pages; a later message of this type about the same replaces it."""

    def on_topics(self, types: Mapping[str, str]) -> None:
        """Take note of the topics, and the type of each."""

    def halt(self) -> None:
        """Forget all samples: the time will be another one. Pages get no frames till then."""

    def resume(self) -> None:
        """Go on, at the time that it is now."""


class DataSource(Protocol):
    """Where messages come from, and what else there is; methods belong to the thread of the web."""

    @property
    def source(self) -> MessageSource:
        """The messages."""

    @property
    def begin(self) -> float:
        """Where bags begin that are laid over it, s."""

    @property
    def layouts(self) -> Layouts:
        """What is known of their types."""

    def start(self, server: Pages) -> None:
        """Begin, and tell a server from now on."""

    def hello(self) -> Dict[str, Any]:
        """Return what the greeting of a page has besides."""

    def messages(self) -> List[Dict[str, Any]]:
        """Return what a new page is told."""

    def handlers(self) -> Dict[str, Handler]:
        """Return what handles requests that are not about the traces of a page."""

    def refresh(self) -> None:
        """Look at once for what is wanted."""

    def leave(self, page: Page) -> None:
        """Forget a page."""
