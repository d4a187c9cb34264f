// The part of rosserial's library that message headers need, for tests without that library.
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
