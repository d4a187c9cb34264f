// Returns its commands.
#include <ros.h>
#include <std_msgs/UInt32.h>

ros::NodeHandle host;
std_msgs::UInt32 last;
ros::Publisher heard("heard", &last);
void on_command(const std_msgs::UInt32 &message) { last.data = message.data; }
ros::Subscriber<std_msgs::UInt32> command("command", on_command);

void setup() {
  host.initNode();
  host.advertise(heard);
  host.subscribe(command);
}

void loop() { heard.publish(&last); host.spinOnce(); delay(4); }
