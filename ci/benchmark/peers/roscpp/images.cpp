// A camera and its subscribers as one would write them with roscpp, in processes of their own or in
// one, as nodelets are, recording each message's number.
// Usage: images publish|subscribe|both image|points BYTES SUBSCRIBERS RECORD...
#include <boost/make_shared.hpp>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "record.h"

template <class Message>
ros::Subscriber subscribe(ros::NodeHandle& node, const char* file)
{
  const auto record = std::make_shared<Record>(file);
  const boost::function<void(const boost::shared_ptr<const Message>&)> receive =
      [record](const boost::shared_ptr<const Message>& message)
  { record->add(monotonic_now(), message->width); };
  return node.subscribe<Message>("images", 10, receive, ros::VoidConstPtr(),
                                 ros::TransportHints().tcpNoDelay());
}

template <class Message>
void publish(ros::NodeHandle& node, const char* file, std::size_t bytes, unsigned connections,
             bool in_one_process)
{
  ros::Publisher publisher = node.advertise<Message>("images", 10);
  Record record(file);
  auto message = boost::make_shared<Message>();
  message->data.resize(bytes, 1);
  while (ros::ok() && publisher.getNumSubscribers() < connections)
    ros::WallDuration(0.05).sleep();
  ros::Rate rate(30.0);
  for (unsigned number = 0; ros::ok(); ++number)
  {
    if (in_one_process)  // a published object belongs to its subscribers
      message = boost::make_shared<Message>(*message);
    message->width = number;
    record.add(monotonic_now(), number);
    if (in_one_process)
      publisher.publish(message);
    else
      publisher.publish(*message);
    rate.sleep();
  }
}

template <class Message>
void run(const std::string& role, std::size_t bytes, unsigned subscribers, char** files)
{
  ros::NodeHandle node;
  const bool is_both = role == "both";
  std::vector<ros::Subscriber> subscriptions;
  for (unsigned n = role == "publish" ? 0 : is_both ? subscribers : 1; n > 0; --n)
    subscriptions.push_back(subscribe<Message>(node, *files++));
  ros::AsyncSpinner spinner(1);
  spinner.start();
  if (role == "subscribe")
    ros::waitForShutdown();
  else
    publish<Message>(node, *files, bytes, is_both ? 1 : subscribers, is_both);
}

int main(int argc, char** argv)
{
  ros::init(argc, argv, "images", ros::init_options::AnonymousName);
  if (argc < 6)
    return 2;
  const std::string role = argv[1], kind = argv[2];
  const std::size_t bytes = std::strtoul(argv[3], nullptr, 10);
  const unsigned subscribers = std::strtoul(argv[4], nullptr, 10);
  if (kind == "image")
    run<sensor_msgs::Image>(role, bytes, subscribers, argv + 5);
  else
    run<sensor_msgs::PointCloud2>(role, bytes, subscribers, argv + 5);
  return 0;
}
