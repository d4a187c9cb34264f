"""What a page is told first: how the scope is set up, and what there is to choose."""

from typing import Any, Dict, Mapping, Sequence

from topic_scope.protocol.options import Options
from topic_scope.record.recorder import Choice


def hello(options: Options, fields: Sequence[str]) -> Dict[str, Any]:
    """Return the message that a page is welcomed with; its origin adds to it.

    :param options: the command line
    :param fields: names of the fields that are shown at first
    """
    return {
        "type": "hello",
        "history": options.history,
        "fields": fields,
        "defaults": {"window": options.window},
        "setup": options.setup,
    }


def choices_message(choices: Sequence[Choice], types: Mapping[str, str]) -> Dict[str, Any]:
    """Return the message that tells what can be chosen.

    :param choices: the fields
    :param types: type of each topic
    """
    listed = [choice._asdict() for choice in choices]
    topics = {choice.topic: types.get(choice.topic, "*") for choice in choices}
    return {"type": "fields", "fields": listed, "types": topics}
