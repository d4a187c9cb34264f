"""Old name of :mod:`nodekit.testing.message_recorder`, kept in 1.x."""

from nodekit.deprecated import warn_once
from nodekit.testing.message_recorder import MessageRecorder

warn_once("nodekit.testing.hearing", "nodekit.testing.message_recorder")

#: Old name of :class:`.MessageRecorder`.
Ear = MessageRecorder
