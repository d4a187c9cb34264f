"""Interface between a scope session and its data source: a live graph or a bag."""

from typing import Any, Dict, List, Mapping, Protocol

from topic_scope.messages.layouts import Layouts
from topic_scope.page.state import Page
from topic_scope.protocol.requests import Handler
from topic_scope.sampling.message_source import MessageSource


class Pages(Protocol):
    """Scope session, as its data source sees it.

    All methods belong to the web thread.
    """

    def pages(self) -> List[Page]:
        """Return the pages that are open."""

    def send_to_pages(self, message: Dict[str, Any], *about: str) -> None:
        """Send to all pages; a later message of this type and subject replaces it."""

    def on_topics(self, types: Mapping[str, str]) -> None:
        """Update the topics and the type of each."""

    def halt(self) -> None:
        """Drop all samples and send no frames until :meth:`resume`: the clock will jump."""

    def resume(self) -> None:
        """Send frames again, from the present time of the clock."""


class DataSource(Protocol):
    """Source of messages, pages' extra data and handlers; used in the web thread only."""

    @property
    def source(self) -> MessageSource:
        """The messages."""

    @property
    def begin(self) -> float:
        """Default start of overlaid bags [s]."""

    @property
    def layouts(self) -> Layouts:
        """Layouts of their types."""

    def start(self, server: Pages) -> None:
        """Start, and report to the session from now on."""

    def hello(self) -> Dict[str, Any]:
        """Return the fields that this source adds to a page's hello message."""

    def messages(self) -> List[Dict[str, Any]]:
        """Return the messages for a new page."""

    def handlers(self) -> Dict[str, Handler]:
        """Return the handlers of requests that are not about a page's traces."""

    def refresh(self) -> None:
        """Check at once for newly requested topics."""

    def leave(self, page: Page) -> None:
        """Remove a page."""
