"""Interface between a scope session and its data source: a live graph or a bag."""

from typing import Any, Callable, Dict, List, Mapping, Optional, Protocol

from topic_scope.messages.layout_cache import Layouts
from topic_scope.page.open_page import Page
from topic_scope.protocol.requests import Handler
from topic_scope.sampling.message_source import MessageSource


class Pages(Protocol):
    """Interface of a scope session for its data source.

    All methods are for the web thread.
    """

    def pages(self) -> List[Page]:
        """Return the open pages."""

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
        """Source of the messages."""

    @property
    def begin(self) -> float:
        """Default start of overlaid bags [s]."""

    @property
    def layouts(self) -> Layouts:
        """Layouts of the messages."""

    def start(self, server: Pages) -> None:
        """Start reporting to the session."""

    def hello(self) -> Dict[str, Any]:
        """Return the fields that this source adds to a page's hello message."""

    def messages(self) -> List[Dict[str, Any]]:
        """Return the messages for a new page."""

    def handlers(self) -> Dict[str, Handler]:
        """Return the handlers of requests that are not about a page's traces."""

    def refresh(self) -> None:
        """Check immediately for newly requested topics."""

    def leave(self, page: Page) -> None:
        """Remove a page."""

    @property
    def read_again(self) -> Optional[Callable[[str, int], Optional[bytes]]]:
        """Reader of earlier messages, by topic and time of receipt [ns]; None if not supported.

        For use by one thread. It returns None if there is no such message.
        """
