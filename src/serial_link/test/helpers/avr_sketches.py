"""Sketches of the tests with a simulated AVR, as users write them."""

import pathlib

#: Beginning of the tests' sketches, before the loop.
COUNTER = """
#include <ros.h>
#include <std_msgs/Float32.h>
#include <std_msgs/UInt16.h>

ros::NodeHandle host;
std_msgs::UInt16 count;
std_msgs::Float32 parameter;
ros::Publisher heard("heard", &count), found("found", &parameter);
void on_command(const std_msgs::UInt16 &message) { count.data++; }
ros::Subscriber<std_msgs::UInt16> command("command", on_command);

void setup() {
  host.initNode();
  host.advertise(heard);
  host.advertise(found);
  host.subscribe(command);
}
"""
WAITS = "void loop() { host.spinOnce(); heard.publish(&count); delay(%d); }"
LOGS = """
void loop() {
  if (host.getParam("gain", &parameter.data)) found.publish(&parameter);
  heard.publish(&count);
  host.logdebug("detail");
  host.loginfo("still here");
  host.logwarn("warm");
  host.logerror("hot");
  host.spinOnce();
  delay(100);
}
"""
LATE = """
#include <ros.h>
#include <std_msgs/UInt16.h>

ros::NodeHandle host;
std_msgs::UInt16 count;
ros::Publisher heard("heard", &count);
void on_command(const std_msgs::UInt16 &message) { count.data = message.data; }
ros::Subscriber<std_msgs::UInt16> command("command", on_command);

void setup() {
  host.initNode();
  while (!host.connected()) host.spinOnce();
  host.subscribe(command);
  host.advertise(heard);
}

void loop() { heard.publish(&count); host.spinOnce(); delay(50); }
"""
FLOOD = """
#include <ros.h>
#include <std_msgs/String.h>

ros::NodeHandle host;
std_msgs::String text;
ros::Publisher heard("heard", &text);
char line[100];
uint16_t count;

void setup() {
  host.initNode();
  host.advertise(heard);
  text.data = line;
}

void loop() {
  sprintf(line, "%05u %090u", count, 0);
  if (heard.publish(&text) > 0) count++;
  host.spinOnce();
}
"""
#: The second topic is announced as by a library that reads its type from the wrong memory.
WRONG = """
#include <ros.h>
#include <std_msgs/Bool.h>

class Unreadable : public std_msgs::Bool {
 public:
  const char *getType() { return "\\x0e\\x94 std_msgs"; }
};

ros::NodeHandle host;
std_msgs::Bool value;
Unreadable garbage;
ros::Publisher dash("my-topic", &value), unreadable("unreadable", &garbage), digit("1st", &value),
    slash("chatter/", &value);

void setup() {
  host.initNode();
  host.advertise(dash);
  host.advertise(unreadable);
  host.advertise(digit);
  host.advertise(slash);
}

void loop() {
  dash.publish(&value);
  unreadable.publish(&garbage);
  digit.publish(&value);
  slash.publish(&value);
  host.spinOnce();
  delay(50);
}
"""
#: Returns its commands, numbers with their complement.
ECHO = (pathlib.Path(__file__).parents[1] / "sketches" / "echo.ino").read_text()
#: Requests two parameters in turn.
ASKS = """
#include <ros.h>
#include <std_msgs/Float32.h>

ros::NodeHandle host;
std_msgs::Float32 value;
ros::Publisher first("found/first", &value), second("found/second", &value);

void setup() {
  host.initNode();
  host.advertise(first);
  host.advertise(second);
}

void loop() {
  if (host.getParam("first", &value.data)) first.publish(&value);
  if (host.getParam("second", &value.data)) second.publish(&value);
  host.spinOnce();
  delay(20);
}
"""
#: Calls a service whose type differs on the board, then another one.
CALLS = """
#include <ros.h>
#include <std_msgs/UInt16.h>
#include <std_srvs/Trigger.h>

class Old : public std_srvs::TriggerRequest {
 public:
  const char *getMD5() { return "00000000000000000000000000000000"; }
};

ros::NodeHandle host;
std_msgs::UInt16 count;
ros::Publisher heard("heard", &count);
ros::ServiceClient<Old, std_srvs::TriggerResponse> differs("differs");
ros::ServiceClient<std_srvs::TriggerRequest, std_srvs::TriggerResponse> answers("answers");

void setup() {
  host.initNode();
  host.advertise(heard);
  host.serviceClient(differs);
  host.serviceClient(answers);
}

void loop() {
  std_srvs::TriggerResponse unchanged, changed;
  unchanged.message = "as before";
  differs.call(Old(), unchanged);
  answers.call(std_srvs::TriggerRequest(), changed);
  if (!strcmp(unchanged.message, "as before") && changed.success) count.data++;
  heard.publish(&count);
  host.spinOnce();
  delay(50);
}
"""
#: The most topics that the library has room for; it refuses others. The first one has a bit for
#: each received number.
MANY = """
#include <ros.h>
#include <std_msgs/UInt32.h>

ros::NodeHandle host;
std_msgs::UInt32 value, received;
void on_value(const std_msgs::UInt32 &message) { received.data |= 1UL << message.data; }
ros::Publisher publishers[] = {%s}, surplus("surplus", &value);
ros::Subscriber<std_msgs::UInt32> subscribers[] = {%s}, too_many("too_many", on_value);

void setup() {
  host.initNode();
  for (ros::Publisher &publisher : publishers) host.advertise(publisher);
  for (ros::Subscriber<std_msgs::UInt32> &subscriber : subscribers) host.subscribe(subscriber);
  if (host.advertise(surplus) || host.subscribe(too_many)) received.data = 1UL << 31;
}

void loop() {
  value.data = (value.data + 1) %% 25;
  publishers[value.data].publish(value.data ? &value : &received);
  host.spinOnce();
}
""" % (
    ", ".join(f'{{"to/p{number}", &value}}' for number in range(25)),
    ", ".join(f'{{"from/p{number}", on_value}}' for number in range(25)),
)
#: Returns the length of each text, and the text if its frame fits into the buffer.
LENGTHS = """
#include <ros.h>
#include <std_msgs/String.h>
#include <std_msgs/UInt16.h>

ros::NodeHandle host;
std_msgs::UInt16 length;
std_msgs::String same;
ros::Publisher heard("heard", &length), echo("echo", &same);
void on_text(const std_msgs::String &message) {
  length.data = strlen(message.data);
  heard.publish(&length);
  if (length.data <= 268) echo.publish(&message);
}
ros::Subscriber<std_msgs::String> text("text", on_text);

void setup() {
  host.getHardware()->setBaud(250000);
  host.initNode();
  host.advertise(heard);
  host.advertise(echo);
  host.subscribe(text);
}

void loop() { host.spinOnce(); }
"""
