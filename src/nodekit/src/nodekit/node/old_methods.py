"""Deprecated names of NodeScope's methods, from nodekit 1.0."""

from nodekit.deprecated import OldMethod, warn_once
from nodekit.groups.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)


class OldMethods:
    """Methods that :class:`.NodeScope` had in nodekit 1.0; each warns once."""

    publisher = OldMethod("create_publisher")
    subscribe = OldMethod("create_subscription")
    subscribe_batches = OldMethod("create_batch_subscription")
    latest = OldMethod("create_latest_message")
    service = OldMethod("create_service")
    client = OldMethod("create_client")
    every = OldMethod("create_timer", rate="rate_hz")
    parameters = OldMethod("declare_parameters")
    follow = OldMethod("on_parameter")
    before_end = OldMethod("on_shutdown")
    stream_log = OldMethod("create_rate_limited_log")
    lifetime = OldMethod("create_scope")

    def group(self, exclusive: bool = True, urgent: bool = False) -> CallbackGroup:
        """Return a new callback group; deprecated, use the classes of callback groups.

        :param exclusive: whether its callbacks exclude each other
        :param urgent: whether an executor makes its calls before those of all other groups
        """
        warn_once("group()", "MutuallyExclusiveCallbackGroup or ReentrantCallbackGroup")
        if exclusive:
            return MutuallyExclusiveCallbackGroup(urgent)
        return ReentrantCallbackGroup(urgent)
