// The process node as one would write it with roscpp: scaled, shifted in phase, lifted.
#include <basic_comms/signal_msg.h>
#include <ros/ros.h>
#include <std_msgs/Float32.h>

#include <cmath>

int main(int argc, char** argv)
{
  ros::init(argc, argv, "process");
  ros::NodeHandle node;
  ros::NodeHandle parameters("~");
  const double scale = parameters.param("amplitude_scale", 0.5);
  const double shift = parameters.param("phase_shift", M_PI / 2.0);
  ros::Publisher publisher = node.advertise<std_msgs::Float32>("proc_signal", 1000);
  const boost::function<void(const basic_comms::signal_msg::ConstPtr&)> answer =
      [&](const basic_comms::signal_msg::ConstPtr& sample) {
        const double phase = sample->frequency * sample->time_x;
        std_msgs::Float32 output;
        output.data = scale * sample->amplitude * (std::sin(phase + shift) + 1.0);
        publisher.publish(output);
      };
  ros::Subscriber subscriber =
      node.subscribe<basic_comms::signal_msg>("signal", 1000, answer, ros::VoidConstPtr(),
                                              ros::TransportHints().tcpNoDelay());
  ros::spin();
  return 0;
}
