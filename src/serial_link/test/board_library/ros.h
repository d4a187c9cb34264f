// Parts of the rosserial and Arduino libraries that a sketch uses, for a host compiler. The functions
// do nothing: they only check that a sketch compiles with the generated headers.
#ifndef ROS_H
#define ROS_H

#include <math.h>
#include <stdint.h>

#include "ros/duration.h"
#include "ros/msg.h"
#include "ros/time.h"

enum { INPUT_PULLUP = 2, OUTPUT = 1, CHANGE = 1 };
const double PI = 3.14159265358979;
inline double constrain(double x, double low, double high) { return x < low ? low : x > high ? high : x; }
void pinMode(uint8_t pin, uint8_t mode);
void digitalWrite(uint8_t pin, uint8_t level);
int digitalRead(uint8_t pin);
void analogWrite(uint8_t pin, int width);
int digitalPinToInterrupt(uint8_t pin);
void attachInterrupt(int number, void (*call)(), int edges);
void interrupts();
void noInterrupts();
unsigned long millis();
unsigned long micros();

namespace ros {

class Publisher {
 public:
  Publisher(const char *topic, Msg *message);
  int publish(const Msg *message);
};

template <typename Message> class Subscriber {
 public:
  Subscriber(const char *topic, void (*call)(const Message &));
};

class Hardware {
 public:
  void setBaud(long baud);
};

class NodeHandle {
 public:
  Hardware *getHardware();
  void initNode();
  int spinOnce();
  bool advertise(Publisher &publisher);
  template <typename Message> bool subscribe(Subscriber<Message> &subscriber);
};

}  // namespace ros

#endif
