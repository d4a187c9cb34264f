"""Tests of the rules that map ROS 1 types to ROS 2 types."""

import pytest

from ros2_bridge.types.mapping_rules import MappingRules, MappingRuleError

RANGE = {"ros1": "sensor_msgs/Range", "ros2": "sensor_msgs/msg/Range"}
MOVE = {
    "ros1": "move_base_msgs/MoveBase",
    "ros2": "nav2_msgs/action/NavigateToPose",
    "fields": {"goal.target_pose": "goal.pose", "feedback.base_position": "feedback.current_pose"},
    "left_out": {"ros2": ["goal.behavior_tree", "result.error_code", "feedback.distance"]},
}


def test_type_has_its_name_in_both():
    rules = MappingRules([RANGE, MOVE])
    assert rules.ros2_name("action", "move_base_msgs/MoveBase") == "nav2_msgs/NavigateToPose"
    assert rules.ros1_name("action", "nav2_msgs/NavigateToPose") == "move_base_msgs/MoveBase"
    assert rules.ros2_name("msg", "std_msgs/String") == ""
    assert rules.ros1_name("msg", "std_msgs/String") == ""
    assert not rules.is_taken("msg", "std_msgs/String", "std_msgs/String")
    assert [rule.kind for rule in rules.own] == ["msg", "action"]


def test_fields_of_an_action_belong_to_its_parts():
    fields = MappingRules([MOVE]).fields
    goal = fields["move_base_msgs/MoveBaseGoal"]
    assert goal.other == "nav2_msgs/NavigateToPose_Goal"
    assert (goal.counterparts, goal.left_out2) == ({"target_pose": "pose"}, ["behavior_tree"])
    assert fields["move_base_msgs/MoveBaseResult"].left_out2 == ["error_code"]
    feedback = fields["move_base_msgs/MoveBaseFeedback"]
    assert feedback.counterparts == {"base_position": "current_pose"}
    assert feedback.left_out2 == ["distance"]


def test_renamed_package_keeps_the_names_of_its_types():
    rules = MappingRules([{"ros1": "acme2_msgs", "ros2": "acme_interfaces"}])
    assert rules.ros2_name("msg", "acme2_msgs/Arm") == "acme_interfaces/Arm"
    assert rules.ros1_name("msg", "acme_interfaces/Arm") == "acme2_msgs/Arm"
    assert rules.own == []


def test_renamed_package_pairs_names_with_their_camel_case():
    rules = MappingRules([{"ros1": "acme_msgs", "ros2": "acme_interfaces"}])
    rules.pair_types("msg", "acme_msgs", ["IMU_data", "Only1"], ["ImuData", "Only2"])
    assert rules.ros2_name("msg", "acme_msgs/IMU_data") == "acme_interfaces/ImuData"
    assert rules.ros1_name("msg", "acme_interfaces/ImuData") == "acme_msgs/IMU_data"
    assert not rules.is_taken("msg", "acme_msgs/IMU_data", "acme_interfaces/ImuData")
    assert rules.ros1_name("msg", "acme_interfaces/Only2") == "acme_msgs/Only2"
    # Without a counterpart, the name is converted to CamelCase.
    assert rules.ros2_name("srv", "acme_msgs/IMU_data") == "acme_interfaces/IMUData"
    assert rules.unclear == {}


def test_rule_for_a_type_takes_precedence_over_that_for_its_package():
    package = {"ros1": "acme_msgs", "ros2": "acme_interfaces"}
    arm = {"ros1": "acme_msgs/arm", "ros2": "acme_interfaces/msg/Limb"}
    rules = MappingRules([package, arm])
    rules.pair_types("msg", "acme_msgs", ["arm", "ARM_"], ["Arm", "Limb"])
    assert rules.ros2_name("msg", "acme_msgs/arm") == "acme_interfaces/Limb"
    assert rules.ros2_name("msg", "acme_msgs/ARM_") == "acme_interfaces/Arm"
    imu = {"ros1": "other_msgs/Imu", "ros2": "acme_interfaces/msg/ImuData"}
    rules = MappingRules([package, imu])
    rules.pair_types("msg", "acme_msgs", ["IMU_data"], ["ImuData"])
    assert rules.ros1_name("msg", "acme_interfaces/ImuData") == "other_msgs/Imu"
    assert rules.ros2_name("msg", "acme_msgs/IMU_data") == "acme_interfaces/IMUData"


def test_ambiguous_name_in_a_renamed_package_needs_a_rule():
    rules = MappingRules([{"ros1": "acme_msgs", "ros2": "acme_interfaces"}])
    rules.pair_types("srv", "acme_msgs", ["get_imu"], ["GetImu", "GetIMU"])
    assert rules.unclear == {
        ("srv", "acme_msgs/get_imu"): "acme_msgs/get_imu: the names get_imu, GetIMU, GetImu differ"
        " only in case and underscores; name its counterpart in acme_interfaces in a mapping rule"
        " for the type"
    }


def test_rule_of_the_user_replaces_one_that_is_built_in():
    own = {**RANGE, "left_out": {"ros2": ["variance"]}}
    rules = MappingRules([own], [RANGE, MOVE])
    assert rules.fields["sensor_msgs/Range"].left_out2 == ["variance"]
    assert [rule.ros1 for rule in rules.own] == ["sensor_msgs/Range"]
    assert rules.ros2_name("action", "move_base_msgs/MoveBase")


def test_entries_without_a_value_are_empty():
    """As YAML has them: ``fields:`` without more."""
    for left_out in (None, {"ros1": None, "ros2": None}):
        rules = MappingRules([{**RANGE, "fields": None, "left_out": left_out}])
        assert rules.fields["sensor_msgs/Range"] == ("sensor_msgs/Range", {}, [], [])


def test_rule_for_a_service_leaves_the_action_of_its_name():
    service = {"ros1": "nav_msgs/GetMap", "ros2": "acme_msgs/srv/GetMap"}
    rules = MappingRules([service])
    assert rules.ros2_name("srv", "nav_msgs/GetMap") == "acme_msgs/GetMap"
    assert rules.ros2_name("action", "nav_msgs/GetMap") == ""
    assert rules.ros1_name("action", "acme_msgs/GetMap") == ""
    rules = MappingRules([service, {**service, "ros2": "acme_msgs/action/GetMap"}])
    assert rules.ros1_name("action", "acme_msgs/GetMap") == "nav_msgs/GetMap"


def test_rule_for_a_package_replaces_those_that_are_built_in_for_its_types():
    rules = MappingRules([{"ros1": "sensor_msgs", "ros2": "acme_sensor_msgs"}], [RANGE])
    assert rules.ros2_name("msg", "sensor_msgs/Range") == "acme_sensor_msgs/Range"
    assert rules.ros1_name("msg", "sensor_msgs/Range") == ""


@pytest.mark.parametrize(
    ("rules", "reason"),
    [
        ("text", "'text' is not a list of rules"),
        (RANGE, "is not a list of rules"),
        ([3], "3 is not a rule with texts ros1 and ros2"),
        ([{"ros1": "a/B"}], "is not a rule with texts ros1 and ros2"),
        ([{**RANGE, "field": {}}], "sensor_msgs/Range: field is not one of fields, left_out"),
        ([{**RANGE, "ros2": "sensor_msgs/Range"}], "types are named as in package/Name"),
        ([{**RANGE, "ros1": "a/b/C"}], "types are named as in package/Name"),
        ([{"ros1": "a", "ros2": "B b"}], "'B b' is not the name of a package"),
        ([{"ros1": "a", "ros2": "b", "fields": {}}], "fields of the package a: allowed only for"),
        (
            [RANGE, {**RANGE, "ros1": "acme_msgs/Range"}],
            "acme_msgs/Range or sensor_msgs/Range is in several rules",
        ),
        ([RANGE, RANGE], "sensor_msgs/Range or sensor_msgs/Range is in several rules"),
        ([{"ros1": "a", "ros2": "b"}, {"ros1": "c", "ros2": "b"}], "c or b is in several rules"),
        ([{**RANGE, "fields": ["x"]}], "fields: ['x'] is not a mapping of texts"),
        ([{**RANGE, "fields": {"x": 3}}], "fields: {'x': 3} is not a mapping of texts"),
        ([{**RANGE, "left_out": ["x"]}], "left_out: ['x'] has other keys than ros1, ros2"),
        ([{**RANGE, "left_out": ["ros1"]}], "left_out: ['ros1'] has other keys than ros1, ros2"),
        ([{**RANGE, "left_out": {"ros3": []}}], "has other keys than ros1, ros2"),
        ([{**RANGE, "left_out": {"ros2": "x"}}], "left_out: {'ros2': 'x'} has no lists of texts"),
        ([{**MOVE, "fields": {"pose": "goal.pose"}}], "pose does not begin with goal, result"),
        ([{**MOVE, "left_out": {"ros1": ["goal"]}}], "goal does not begin with goal, result"),
        (
            [{**MOVE, "fields": {"goal.x": "result.x"}}],
            "goal.x has a counterpart in another part",
        ),
    ],
)
def test_malformed_rule_is_rejected_with_its_reason(rules, reason):
    with pytest.raises(MappingRuleError) as caught:
        MappingRules(rules)
    assert str(caught.value).startswith("parameter mappings: ")
    assert str(caught.value).count("mappings") == 1
    assert reason in str(caught.value)
