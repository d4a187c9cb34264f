// The process node as one would write it with roscpp: scaled, shifted in phase, lifted.
#include <basic_comms/signal_msg.h>
#include <ros/ros.h>
#include <std_msgs/Float32.h>

#include <cmath>

// Answers each sample while it exists; parameters ~amplitude_scale, ~phase_shift.
class Answer
{
public:
  Answer()
  {
    ros::NodeHandle node;
    ros::NodeHandle parameters("~");
    scale_ = parameters.param("amplitude_scale", 0.5);
    shift_ = parameters.param("phase_shift", M_PI / 2.0);
    publisher_ = node.advertise<std_msgs::Float32>("proc_signal", 1000);
    subscriber_ = node.subscribe("signal", 1000, &Answer::answer, this,
                                 ros::TransportHints().tcpNoDelay());
  }

private:
  void answer(const basic_comms::signal_msg::ConstPtr& sample)
  {
    const double phase = sample->frequency * sample->time_x;
    std_msgs::Float32 output;
    output.data = scale_ * sample->amplitude * (std::sin(phase + shift_) + 1.0);
    publisher_.publish(output);
  }

  double scale_;
  double shift_;
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
};

int main(int argc, char** argv)
{
  ros::init(argc, argv, "process");
  Answer answer;
  ros::spin();
  return 0;
}
