"""Services that describe a node's parameters, and change them in one step."""

from types import MethodType
from typing import Any, Callable, Dict, Tuple

from std_srvs.srv import TriggerRequest, TriggerResponse

from nodekit.master import MasterUnreachable
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.parameters import yaml_text
from nodekit.parameters.declaration import ParameterSet
from nodekit.parameters.parameter_types import ParameterError, format_value, to_wire
from nodekit.parameters.schema import as_yaml, describe
from nodekit_msgs.srv import SetParametersRequest, SetParametersResponse

#: Base names of the services, in the namespace of the parameters: std_srvs/Trigger, and
#: nodekit_msgs/SetParameters.
DESCRIBE, CHANGE = "describe", "change"
#: Longest request for changes [characters]: enough for a list of about ten thousand numbers.
LONGEST = 100_000


def description_handler(
    live: LiveParameters[Any],
) -> Callable[[TriggerRequest], TriggerResponse]:
    """Return the handler of the service ``~describe``.

    :param live: the parameters
    :returns: a function; its response's ``message`` is a YAML list with one entry for each
        parameter, in the order of declaration
    """
    return MethodType(_describe, live)  # a closure takes four times the memory


def _describe(live: LiveParameters[Any], _request: TriggerRequest) -> TriggerResponse:
    return TriggerResponse(True, as_yaml(describe(live.values, live.takes_effect)))


def change_handler(
    live: LiveParameters[Any],
) -> Callable[[SetParametersRequest], SetParametersResponse]:
    """Return the handler of the service ``~change``.

    :param live: the parameters
    :returns: a function that makes all requested changes or, if a value is rejected, none
    """
    return MethodType(_answer, live)  # a closure takes four times the memory


def _answer(live: LiveParameters[Any], request: SetParametersRequest) -> SetParametersResponse:
    success, message = _change(live, request.yaml)
    return SetParametersResponse(success, message, _values_as_yaml(live.values))


def _change(live: LiveParameters[Any], text: str) -> Tuple[bool, str]:
    """Return whether the changes are made, and the reason if not."""
    try:
        live.change(_settings(text))
    except ParameterError as error:
        return False, str(error)
    except MasterUnreachable as error:
        return False, f"the master does not answer ({error}): nothing is changed"
    except ValueError as error:
        return False, f"malformed request: {error}"
    return True, ""


def _settings(text: str) -> Dict[str, Any]:
    """Return the new values by name.

    :raises ValueError: if the text is not a mapping of names to values
    """
    if len(text) > LONGEST:
        raise ValueError(f"{len(text)} characters: must be at most {LONGEST}")
    settings = yaml_text.load(text)
    if settings is None:
        return {}
    if not isinstance(settings, dict):
        raise ValueError(f"{format_value(settings)} is not a mapping of names to values")
    return {str(name): value for name, value in settings.items()}


def _values_as_yaml(values: ParameterSet) -> str:
    settings = {name: to_wire(value) for name, value in values.as_dict().items()}
    return yaml_text.dump(settings)
