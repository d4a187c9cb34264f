// The signal generator as one would write it with roscpp. Usage: generator RECORD
#include <basic_comms/signal_msg.h>
#include <boost/make_shared.hpp>
#include <ros/ros.h>

#include <cmath>

#include "record.h"

int main(int argc, char** argv)
{
  ros::init(argc, argv, "signal_generator");
  if (argc != 2)
    return 2;
  ros::NodeHandle node;
  ros::Publisher publisher = node.advertise<basic_comms::signal_msg>("signal", 1000);
  Record record(argv[1]);
  ros::Rate rate(ros::NodeHandle("~").param("rate", 10.0));
  const ros::Time start = ros::Time::now();
  while (ros::ok())
  {
    const basic_comms::signal_msgPtr sample = boost::make_shared<basic_comms::signal_msg>();
    sample->amplitude = 2.0;
    sample->frequency = 2.0 * M_PI;
    sample->time_x = (ros::Time::now() - start).toSec();
    sample->signal_y = sample->amplitude * std::sin(sample->frequency * sample->time_x);
    record.add(monotonic_now(), sample->signal_y);
    publisher.publish(sample);
    rate.sleep();
  }
  return 0;
}
