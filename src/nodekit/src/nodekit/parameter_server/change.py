"""Let others change parameters of a node in one step, and learn why not."""

from types import MethodType
from typing import Any, Callable, Dict, Tuple

import yaml

from nodekit.master import MasterUnreachable
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.parameters.declaration import ParameterSet
from nodekit.parameters.kinds import ParameterError, format_value, to_wire
from nodekit_msgs.srv import SetParametersRequest, SetParametersResponse

#: Base name of the service (nodekit_msgs/SetParameters), in the namespace of the parameters.
SERVICE = "change"


def change_handler(
    live: LiveParameters[Any],
) -> Callable[[SetParametersRequest], SetParametersResponse]:
    """Return what answers the service.

    :param live: the parameters
    :returns: a function that changes all that is asked for or, where one value is refused, nothing
    """
    return MethodType(_answer, live)  # a closure takes four times the memory of that


def _answer(live: LiveParameters[Any], request: SetParametersRequest) -> SetParametersResponse:
    success, message = _change(live, request.yaml)
    return SetParametersResponse(success, message, _as_yaml(live.values))


def _change(live: LiveParameters[Any], text: str) -> Tuple[bool, str]:
    """Return whether all is in force, and why not."""
    try:
        live.change(_settings(text))
    except ParameterError as error:
        return False, str(error)
    except MasterUnreachable as error:
        return False, f"the master does not answer ({error}): nothing is changed"
    except ValueError as error:
        return False, f"no change of parameters: {error}"
    return True, ""


def _settings(text: str) -> Dict[str, Any]:
    """Return new values by name.

    :raises ValueError: if the text is something else
    """
    try:
        # With aliases, a short text can stand for a value without end.
        if any(isinstance(token, yaml.AliasToken) for token in yaml.scan(text)):
            raise ValueError("aliases (*name) are not taken")
        settings = yaml.safe_load(text)
    except (yaml.YAMLError, RecursionError, LookupError) as error:  # the last of a value's tag
        raise ValueError(f"no YAML: {' '.join(str(error).split())}") from None
    if settings is None:
        return {}
    if not isinstance(settings, dict):
        raise ValueError(f"{format_value(settings)} is no mapping of names to values")
    return {str(name): value for name, value in settings.items()}


def _as_yaml(values: ParameterSet) -> str:
    settings = {name: to_wire(value) for name, value in values.as_dict().items()}
    return str(yaml.safe_dump(settings, sort_keys=False, allow_unicode=True, width=1000))
