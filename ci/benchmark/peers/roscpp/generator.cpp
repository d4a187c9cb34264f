// The signal generator as one would write it with roscpp. Usage: generator RECORD
#include <basic_comms/signal_msg.h>
#include <boost/make_shared.hpp>
#include <ros/ros.h>

#include <cmath>

#include "record.h"

// Publish until the node ends; parameters ~rate, ~amplitude, ~frequency.
void generate(const char* file)
{
  ros::NodeHandle node;
  ros::NodeHandle parameters("~");
  const double hz = parameters.param("rate", 10.0);
  const double amplitude = parameters.param("amplitude", 2.0);
  const double frequency = parameters.param("frequency", 2.0 * M_PI);
  ros::Publisher publisher = node.advertise<basic_comms::signal_msg>("signal", 1000);

  Record record(file);
  ros::Rate rate(hz);
  const ros::Time start = ros::Time::now();
  while (ros::ok())
  {
    const basic_comms::signal_msgPtr sample = boost::make_shared<basic_comms::signal_msg>();
    sample->amplitude = amplitude;
    sample->frequency = frequency;
    sample->time_x = (ros::Time::now() - start).toSec();
    sample->signal_y = amplitude * std::sin(frequency * sample->time_x);
    record.add(monotonic_now(), sample->signal_y);
    publisher.publish(sample);
    rate.sleep();
  }
}

int main(int argc, char** argv)
{
  ros::init(argc, argv, "signal_generator");
  if (argc != 2)
    return 2;
  generate(argv[1]);
  return 0;
}
