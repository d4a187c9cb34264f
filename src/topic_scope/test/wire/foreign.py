"""Node with dynamic_reconfigure and without nodekit."""

from typing import Any, Dict, List, Tuple

from dynamic_reconfigure.server import Server

#: Name, type, default, minimum, maximum, and edit method.
_PARAMETERS: List[Tuple[str, str, Any, Any, Any, str]] = [
    ("gain", "double", 1.0, 0.0, 10.0, ""),
    ("count", "int", 3, -(2**31), 2**31 - 1, ""),
    ("on", "bool", True, False, True, ""),
    (
        "rate",
        "int",
        10,
        10,
        100,
        str({"enum": [{"name": "Low", "value": 10}, {"name": "High", "value": 100}]}),
    ),
    (
        "mode",
        "str",
        "slow",
        "",
        "",
        str({"enum": [{"name": name, "value": name.lower()} for name in ("Slow", "Fast")]}),
    ),
]


class Kind:
    """Module generated from a .cfg file."""

    defaults = {name: default for name, _, default, *_ in _PARAMETERS}
    min = {name: low for name, _, _, low, _, _ in _PARAMETERS}
    max = {name: high for name, _, _, _, high, _ in _PARAMETERS}
    config_description = {
        "name": "Default",
        "type": "",
        "state": True,
        "id": 0,
        "parent": 0,
        "groups": [],
        "parameters": [
            {
                "name": name,
                "type": kind,
                "level": 0,
                "description": f"the {name}",
                "edit_method": edit,
            }
            for name, kind, *_, edit in _PARAMETERS
        ],
    }


class Foreign:
    """Node that keeps its values, and limits the gain to 5.

    :param namespace: global namespace of the parameters
    """

    def __init__(self, namespace: str) -> None:
        self.values: Dict[str, Any] = {}
        self._server = Server(Kind, self._on_change, namespace)

    def _on_change(self, config: Any, _level: int) -> Any:
        config["gain"] = min(config["gain"], 5.0)
        self.values = dict(config)
        return config

    def close(self) -> None:
        """Leave the graph."""
        self._server.set_service.shutdown()
        self._server.descr_topic.unregister()
        self._server.update_topic.unregister()
