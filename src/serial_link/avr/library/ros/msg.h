// The part of rosserial's library that message headers need, for tests without that library.
#ifndef ROS_MSG_H
#define ROS_MSG_H

namespace ros {

class Msg {
 public:
  virtual int serialize(unsigned char *outbuffer) const = 0;
  virtual int deserialize(unsigned char *inbuffer) = 0;
  virtual const char *getType() = 0;
  virtual const char *getMD5() = 0;
};

}  // namespace ros

#endif
