"""Registry of types that exist in both ROSes: ROS 1's from files, ROS 2's imported."""

import contextlib
import importlib
import importlib.util
import pathlib
import sys
import threading
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Tuple, Union

import genmsg.gentools
import genmsg.msg_loader
import rospkg
import rospy
import yaml

from nodekit.message_definitions import Fields, parse
from ros2_bridge.rules.skip_log import Unbridgeable
from ros2_bridge.types.codec import Codec, MappedCodec
from ros2_bridge.types.compatibility import difference, in_ros1_terms
from ros2_bridge.types.definition_folders import DefinitionFolders, names_in_package, shared_types
from ros2_bridge.types.field_mapping import FieldMapping, MappingError, unassigned
from ros2_bridge.types.mapping_rules import (
    PARTS,
    MappingRuleError,
    MappingRules,
    is_type_name,
)
from ros2_bridge.types.ros2_interfaces import twin_type

#: Exceptions for a type that does not exist.
_UNKNOWN = (genmsg.msg_loader.MsgNotFound, ImportError, AttributeError)
#: Converter of a type: with the same fields in both ROSes, or by mapping rules.
AnyCodec = Union[Codec, MappedCodec]


class MessageType(NamedTuple):
    """A message type.

    :param ros1, ros2: its names
    :param raw: ROS 1 class of serialized messages
    :param cls: ROS 2 class
    """

    ros1: str
    ros2: str
    raw: Any
    cls: Any
    codec: AnyCodec


class ServiceType(NamedTuple):
    """A service type.

    :param ros1, ros2: its names
    :param raw: ROS 1 class with serialized requests and responses
    :param cls: ROS 2 class
    """

    ros1: str
    ros2: str
    raw: Any
    cls: Any
    request: AnyCodec
    response: AnyCodec


class ActionType(NamedTuple):
    """An action type.

    :param ros1, ros2: its names
    :param cls: ROS 2 class
    :param goal, result, feedback: codecs of the user's definitions
    :param raw_goal, raw_result, raw_feedback: ROS 1 classes of serialized messages: header and id,
        or header and status, and then the user's definition
    """

    ros1: str
    ros2: str
    cls: Any
    goal: AnyCodec
    result: AnyCodec
    feedback: AnyCodec
    raw_goal: Any
    raw_result: Any
    raw_feedback: Any


class TypeRegistry:
    """Registry of types; thread-safe.

    :param mappings: the user's mapping rules, see :class:`.MappingRules`; None for none
    :raises MappingRuleError: if one is malformed, or does not fit its types
    """

    def __init__(self, mappings: Any = None) -> None:
        names = pathlib.Path(sys.prefix, "share", "ros2_bridge", "names.yaml")
        self._names: Mapping[str, str] = yaml.safe_load(names.read_text("utf-8"))
        left_out = names.with_name("left_out.yaml")
        self._left_out: Mapping[str, str] = {}
        if left_out.exists():  # an earlier release wrote no such file
            self._left_out = yaml.safe_load(left_out.read_text("utf-8"))
        self._back = {its: ours for ours, its in self._names.items() if "/" in ours}
        self._folders = DefinitionFolders(rospkg.RosPack())
        self._known: Dict[Tuple[str, str], Any] = {}
        self._lock = threading.Lock()
        builtin = pathlib.Path(rospkg.RosPack().get_path("ros2_bridge"), "config", "mappings.yaml")
        self._builtin = yaml.safe_load(builtin.read_text("utf-8"))["mappings"]
        self._rules = MappingRules([] if mappings is None else mappings, self._builtin)
        self._check_rules()

    def _check_rules(self) -> None:
        finders = {"msg": self.message, "srv": self.service, "action": self.action}
        errors = []
        for ours, its in self._rules.packages.items():
            if ours not in self._folders:
                errors.append(f"package {ours} is not installed in ROS 1")
            if importlib.util.find_spec(its) is None:
                errors.append(f"package {its} is not installed in ROS 2")
            for kind in PARTS:
                names = names_in_package(self._folders.packages, ours, kind)
                self._rules.pair_types(kind, ours, names, _names_in_ros2(its, kind))
        for rule in self._rules.own:
            try:
                finders[rule.kind](rule.ros1)
            except Unbridgeable as reason:
                errors.append(str(reason))
        if errors:
            raise MappingRuleError("; ".join(errors))

    def candidates(self) -> List[Tuple[str, str]]:
        """Return kind and name of each ROS 1 type in shared packages or in the rules."""
        own = [(rule.kind, rule.ros1) for rule in self._rules.own]
        return list(dict.fromkeys([*shared_types(self._rules.packages), *own]))

    def ros2_name(self, kind: str, name: str) -> str:
        """Return the ROS 2 name, ``package/Name``, of a ROS 1 message, service or action type."""
        return self._rules.ros2_name(kind, name) or self._names.get(name) or twin_type(name)

    def ros1_name(self, name: str) -> str:
        """Return the ROS 1 name of a ROS 2 type, ``package/msg/Name``.

        It is the argument itself if a mapping rule gives the ROS 1 type another counterpart.
        """
        package, _, rest = name.partition("/")
        kind, _, base = rest.rpartition("/")
        short = f"{package}/{base}"
        found = self._rules.ros1_name(kind, short) or self._back.get(short, short)
        return name if self._rules.is_taken(kind, found, short) else found

    def message(self, name: str) -> MessageType:
        """Return the message type with a ROS 1 name.

        :raises Unbridgeable: if it is unknown in one of the ROSes, or differs
        """
        return self._find("msg", name, self._make_message)

    def service(self, name: str) -> ServiceType:
        """Return the service type with a ROS 1 name.

        :raises Unbridgeable: if it is unknown in one of the ROSes, or differs
        """
        return self._find("srv", name, self._make_service)

    def action(self, name: str) -> ActionType:
        """Return the action type with a ROS 1 name.

        :raises Unbridgeable: if it is unknown in one of the ROSes, or differs
        """
        found: ActionType = self._find("action", name, self._make_action)
        return found

    def draft(self, ros1: str, ros2: str) -> Dict[str, Any]:
        """Return a mapping rule for two types, which leaves out fields without a counterpart.

        :param ros1, ros2: names as in a rule
        :raises MappingRuleError: if they are malformed
        :raises Unbridgeable: if one is not installed, or has a type that the other ROS lacks
        """
        rules = MappingRules([{"ros1": ros1, "ros2": ros2}], self._builtin)
        if not rules.own:
            raise MappingRuleError(f"{ros1} and {ros2}: a draft is of a rule for types")
        (rule,) = rules.own
        context = genmsg.MsgContext.create_default()
        with _explaining(f"{rule.kind} {ros1} is not installed in ROS 1"):
            if rule.kind == "srv":
                service = genmsg.msg_loader.load_srv_by_type(context, ros1, self._folders)
                specs = [service.request, service.response]
            else:
                names = [ros1 + part for part in PARTS[rule.kind]]
                load = genmsg.msg_loader.load_msg_by_type
                specs = [load(context, name, self._folders) for name in names]
        package, kind, base = ros2.split("/")
        with _explaining(f"{ros2} is not installed in ROS 2"):
            top = _ros2_class(package, kind, base)
        left_out: Dict[str, List[str]] = {"ros1": [], "ros2": []}
        for part, spec in zip(PARTS[rule.kind], specs):
            cls = getattr(top, part) if part else top
            fields = parse(ros1 + part, self._raw(context, spec, ros1 + part)._full_text)
            other, theirs = self._ros2_fields(cls)
            missing = unassigned(ros1 + part, fields, other, theirs, rules.fields)
            prefix = f"{part.lower()}." if part else ""
            for side, paths in zip(left_out.values(), missing):
                side += [prefix + path for path in paths]
        return {"ros1": ros1, "ros2": ros2, "fields": {}, "left_out": left_out}

    def _find(self, kind: str, name: str, make: Callable[[str], Any]) -> Any:
        if name.count("/") == 2:  # see ros1_name()
            raise Unbridgeable(f"{name}: a mapping rule gives its ROS 1 type another ROS 2 type")
        with self._lock:
            if (kind, name) not in self._known:
                try:
                    self._known[kind, name] = make(name)
                except Unbridgeable as reason:
                    self._known[kind, name] = reason
            found = self._known[kind, name]
        if isinstance(found, Unbridgeable):
            raise found
        return found

    def _make_message(self, name: str) -> MessageType:
        context = genmsg.MsgContext.create_default()
        with _explaining(f"type {name} is not installed in ROS 1"):
            spec = genmsg.msg_loader.load_msg_by_type(context, name, self._folders)
        cls = self._import(name, "msg")
        codec, raw = self._part(context, spec, name, cls)
        return MessageType(name, self.ros2_name("msg", name), raw, cls, codec)

    def _make_service(self, name: str) -> ServiceType:
        context = genmsg.MsgContext.create_default()
        with _explaining(f"service type {name} is not installed in ROS 1"):
            spec = genmsg.msg_loader.load_srv_by_type(context, name, self._folders)
            genmsg.msg_loader.load_depends(context, spec, self._folders)
            md5sum = genmsg.gentools.compute_md5(context, spec)
        cls = self._import(name, "srv")
        parts = [
            self._part(context, part, name + kind, getattr(cls, kind))
            for part, kind in ((spec.request, "Request"), (spec.response, "Response"))
        ]
        (request, request_class), (response, response_class) = parts
        attributes = {
            "_type": name,
            "_md5sum": md5sum,
            "_request_class": request_class,
            "_response_class": response_class,
        }
        raw = type("Raw", (), attributes)
        return ServiceType(name, self.ros2_name("srv", name), raw, cls, request, response)

    def _make_action(self, name: str) -> ActionType:
        context = genmsg.MsgContext.create_default()
        cls = self._import(name, "action")
        codecs, raws = [], []
        for part in ("Goal", "Result", "Feedback"):
            with _explaining(f"action type {name} is not installed in ROS 1"):
                spec, whole = (
                    genmsg.msg_loader.load_msg_by_type(context, f"{name}{kind}", self._folders)
                    for kind in (part, f"Action{part}")
                )
            codecs.append(self._part(context, spec, name + part, getattr(cls, part))[0])
            raws.append(self._raw(context, whole, f"{name}Action{part}"))
        return ActionType(name, self.ros2_name("action", name), cls, *codecs, *raws)

    def _raw(self, context: Any, spec: Any, name: str) -> Any:
        """Return a ROS 1 class of serialized messages."""
        with _explaining(f"invalid definition of {name} in ROS 1"):
            genmsg.msg_loader.load_depends(context, spec, self._folders)
            md5sum = genmsg.gentools.compute_md5(context, spec)
            text = genmsg.gentools.compute_full_text(context, spec)
        attributes = {"_type": name, "_md5sum": md5sum, "_full_text": text, "_has_header": False}
        # The class is never pickled, so its module does not matter.
        return type("Raw", (rospy.AnyMsg,), {**attributes, "__slots__": ["_buff"]})

    def _part(self, context: Any, spec: Any, name: str, cls: Any) -> Tuple[AnyCodec, Any]:
        """Return codec and raw class of a message, or of a part of a service or action."""
        raw = self._raw(context, spec, name)
        with _explaining(f"invalid definition of {name} in ROS 1"):
            fields = parse(name, raw._full_text)
            codec = Codec(name, fields)
        other = _name_of(cls)
        found = difference(name, fields, other, lambda its: self._describe(its, cls))
        if not found and not self._rules.assigns_fields(fields):
            return codec, raw
        if not set(self._rules.fields).intersection(fields):
            raise Unbridgeable(f"{name} differs between ROS 1 and ROS 2: {found}")
        mapping, codec2 = self._mapping(name, fields, cls)
        if not found and mapping.is_copy:  # the rules are for another ROS 2 type
            return codec, raw
        return MappedCodec(codec2, mapping, fields, name), raw

    def _ros2_fields(self, cls: Any) -> Tuple[str, Fields]:
        """Return name and fields of a ROS 2 class, in ROS 1's terms."""
        name = _name_of(cls)
        try:
            return name, in_ros1_terms(name, lambda its: self._describe(its, cls))
        except ValueError as error:
            raise Unbridgeable(str(error)) from None

    def _mapping(self, name: str, fields: Fields, cls: Any) -> Tuple[FieldMapping, Codec]:
        """Return the converter of a type by mapping rules, and the codec of the ROS 2 type."""
        other, theirs = self._ros2_fields(cls)
        try:

            def default(datatype: str) -> bytes:
                serialize = importlib.import_module("rclpy.serialization").serialize_message
                return Codec(datatype, theirs).to_ros1(serialize(self._class(datatype, cls)()))

            mapping = FieldMapping(name, fields, other, theirs, self._rules.fields, default)
        except MappingError as error:
            raise Unbridgeable(f"{name}: its mapping rule does not fit: {error}") from None
        return mapping, Codec(other, theirs)

    def _import(self, name: str, kind: str) -> Any:
        if (kind, name) in self._rules.unclear:
            raise Unbridgeable(self._rules.unclear[kind, name])
        package, _, base = self.ros2_name(kind, name).partition("/")
        source = f"{name.replace('/', f'/{kind}/')}.{kind}"
        reason = self._left_out.get(source) or self._left_out.get(name.partition("/")[0])
        why = f" ({reason})" if reason else ""
        missing = f"{name} needs {package}/{kind}/{base}, which is not installed in ROS 2{why}"
        with _explaining(missing):
            return _ros2_class(package, kind, base)

    def _describe(self, name: str, top: Any) -> Mapping[str, str]:
        """Return the fields of a ROS 2 type: of the class itself, or of a nested one."""
        fields: Mapping[str, str] = self._class(name, top).get_fields_and_field_types()
        return fields

    @staticmethod
    def _class(name: str, top: Any) -> Any:
        """Return a ROS 2 class: the class itself, or the class of a nested message."""
        package, _, base = name.partition("/")
        if name != _name_of(top):
            with contextlib.suppress(ImportError, AttributeError):
                return getattr(importlib.import_module(f"{package}.msg"), base)
        return top


def _ros2_class(package: str, kind: str, base: str) -> Any:
    """Return the ROS 2 class of a type.

    :param kind: ``msg``, ``srv`` or ``action``
    :raises ImportError: if only ROS 1 has the package
    """
    cls = getattr(importlib.import_module(f"{package}.{kind}"), base)
    if hasattr(cls, "_md5sum"):  # a ROS 1 class, also on the path
        raise ImportError(cls)
    return cls


def _names_in_ros2(package: str, kind: str) -> List[str]:
    """Return the names of a ROS 2 package's types of one kind, without the package."""
    try:
        found = importlib.import_module(f"{package}.{kind}")
    except ImportError:  # no types of this kind
        return []
    return [name for name in dir(found) if is_type_name(name)]


def _name_of(cls: Any) -> str:
    """Return the name of a ROS 2 class, ``package/Name``."""
    return f"{cls.__module__.partition('.')[0]}/{cls.__name__}"


@contextlib.contextmanager
def _explaining(what: str) -> Any:
    """Convert library exceptions for an unavailable type to :class:`Unbridgeable`."""
    try:
        yield
    except Unbridgeable:
        raise
    except Exception as error:  # of any kind: genmsg and rclpy have many
        raise Unbridgeable(what if isinstance(error, _UNKNOWN) else f"{what} ({error})") from None
