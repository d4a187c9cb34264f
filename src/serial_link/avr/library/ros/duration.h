// The part of rosserial's library that message headers need, for tests without that library.
#ifndef ROS_DURATION_H
#define ROS_DURATION_H

#include <stdint.h>

namespace ros {

class Duration {
 public:
  int32_t sec, nsec;
  Duration() : sec(0), nsec(0) {}
};

}  // namespace ros

#endif
