// The process node as one would write it with roscpp: scaled, shifted in phase, lifted.
#include <basic_comms/signal_msg.h>
#include <ros/ros.h>
#include <std_msgs/Float32.h>

#include <cmath>

ros::Publisher publisher;

void answer(const basic_comms::signal_msg::ConstPtr& sample)
{
  const double phase = sample->frequency * sample->time_x;
  std_msgs::Float32 output;
  output.data = 0.5 * sample->amplitude * (std::sin(phase + M_PI / 2.0) + 1.0);
  publisher.publish(output);
}

int main(int argc, char** argv)
{
  ros::init(argc, argv, "process");
  ros::NodeHandle node;
  publisher = node.advertise<std_msgs::Float32>("proc_signal", 1000);
  const ros::Subscriber subscriber =
      node.subscribe("signal", 1000, answer, ros::TransportHints().tcpNoDelay());
  ros::spin();
  publisher.shutdown();  // before the client library ends
  return 0;
}
