// What headers of messages need of rosserial's library for boards, for tests without that.
#ifndef ROS_TIME_H
#define ROS_TIME_H

#include <stdint.h>

namespace ros {

class Time {
 public:
  uint32_t sec, nsec;
  Time() : sec(0), nsec(0) {}
};

}  // namespace ros

#endif
