"""What a page may ask of a bag that is played."""

from typing import Any, Callable, Dict, NamedTuple, Optional

from topic_scope.protocol.checks import TIMES, RequestError, number_of

#: How much slower and faster than it was recorded a bag may be played.
SPEEDS = (0.01, 100.0)


class Playback(NamedTuple):
    """Play a bag otherwise; what is None stays as it is.

    :param playing: whether its clock goes
    :param time: where to go to, s since the epoch
    :param speed: how much faster than it was recorded
    """

    playing: Optional[bool] = None
    time: Optional[float] = None
    speed: Optional[float] = None


def _playback(request: Dict[str, Any]) -> Playback:
    playing = request.get("playing")
    if playing is not None and not isinstance(playing, bool):
        raise RequestError("playback: playing is true or false")
    time, speed = (
        None if request.get(key) is None else number_of(request, "playback", key, *limits)
        for key, limits in (("time", TIMES), ("speed", SPEEDS))
    )
    return Playback(playing, time, speed)


READERS: Dict[str, Callable[[Dict[str, Any]], Playback]] = {"playback": _playback}
