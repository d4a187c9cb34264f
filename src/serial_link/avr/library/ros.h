// Device side of rosserial's protocol for sketches on the simulated AVR, with the API that sketches
// use of rosserial's Arduino library. That library is not in any archive available to tests. This
// one behaves on the wire like its node_handle.h in version 0.7.8: it publishes only while
// configured, forgets a host after 11 s, drops a frame that is incomplete after 20 ms, and returns
// early from spinOnce after a topic request, which also ends the wait of a service call.
#ifndef ROS_H
#define ROS_H

#include <Arduino.h>
#include <avr/sleep.h>

#include "ros/duration.h"
#include "ros/msg.h"
#include "ros/time.h"

// Called by delay(). The simulator skips the time until the next interrupt.
extern "C" __attribute__((weak)) void yield() {
  set_sleep_mode(SLEEP_MODE_IDLE);
  sleep_mode();
}

namespace ros {

enum { PUBLISHER, SUBSCRIBER, CALLER = 4, PARAMETER = 6, LOG = 7, TIME = 10, STOP = 11 };
const uint16_t FIRST_TOPIC = 100;
const uint16_t TOPICS = 25, SIZE = 280;
const unsigned long FRAME_MS = 20, TIME_EVERY_MS = 2500, FORGETS_MS = 11000;

class Sender {
 public:
  virtual int publish(int id, const Msg *message) = 0;
  virtual bool connected() = 0;
  virtual int spinOnce() = 0;
};

class Publisher {
 public:
  Publisher(const char *topic, Msg *message, uint8_t kind = PUBLISHER)
      : topic(topic), message(message), kind(kind) {}
  int publish(const Msg *sent) { return sender->publish(id, sent); }

  const char *topic;
  Msg *message;
  uint8_t kind;
  int id;
  Sender *sender;
};

class Receiver {
 public:
  virtual void receive(unsigned char *payload) = 0;
  virtual Msg *blank() = 0;
  virtual uint8_t kind() { return SUBSCRIBER; }
  const char *topic;
  int id;
};

template <typename Message> class Subscriber : public Receiver {
 public:
  typedef void (*Callback)(const Message &);
  Subscriber(const char *name, Callback callback) : callback_(callback) { topic = name; }
  void receive(unsigned char *payload) {
    message_.deserialize(payload);
    callback_(message_);
  }
  Msg *blank() { return &message_; }

 private:
  Message message_;
  Callback callback_;
};

template <typename Request, typename Response> class ServiceClient : public Receiver {
 public:
  explicit ServiceClient(const char *name) : requests(name, &request_, CALLER + PUBLISHER) {
    topic = name;
  }
  uint8_t kind() { return CALLER + SUBSCRIBER; }
  Msg *blank() { return &blank_; }

  // Return with an unchanged response if the host requests the topics, or is lost.
  void call(const Request &request, Response &response) {
    if (!requests.sender->connected()) return;
    response_ = &response;
    requests.publish(&request);
    while (response_ && requests.sender->connected() && requests.sender->spinOnce() >= 0) {}
    response_ = NULL;
  }
  void receive(unsigned char *payload) {
    if (response_) response_->deserialize(payload);
    response_ = NULL;
  }

  Publisher requests;

 private:
  Request request_;
  Response blank_, *response_ = NULL;
};

class Hardware {
 public:
  void setBaud(long baud) { baud_ = baud; }
  void init() { Serial.begin(baud_); }

 private:
  long baud_ = 57600;
};

class NodeHandle : public Sender {
 public:
  Hardware *getHardware() { return &hardware_; }
  void initNode() { hardware_.init(); }
  bool connected() { return is_configured_; }

  bool advertise(Publisher &publisher) {
    if (publishers_count_ == TOPICS) return false;
    publisher.id = FIRST_TOPIC + TOPICS + publishers_count_;
    publisher.sender = this;
    publishers_[publishers_count_++] = &publisher;
    return true;
  }

  bool subscribe(Receiver &subscriber) {
    if (subscribers_count_ == TOPICS) return false;
    subscriber.id = FIRST_TOPIC + subscribers_count_;
    subscribers_[subscribers_count_++] = &subscriber;
    return true;
  }

  template <typename Request, typename Response>
  bool serviceClient(ServiceClient<Request, Response> &client) {
    return advertise(client.requests) && subscribe(client);
  }

  int publish(int id, const Msg *message) {
    if (id >= FIRST_TOPIC && !is_configured_) return 0;
    return send(id, message->serialize(out_ + 7));
  }

  void logdebug(const char *text) { log(0, text); }
  void loginfo(const char *text) { log(1, text); }
  void logwarn(const char *text) { log(2, text); }
  void logerror(const char *text) { log(3, text); }

  bool getParam(const char *name, float *value) {
    send(PARAMETER, put_text(out_ + 7, name));
    has_parameter_ = false;
    for (unsigned long began = millis(); millis() - began < 1000; spinOnce()) {
      if (!has_parameter_) continue;
      *value = parameter_;
      return true;
    }
    return false;
  }

  int spinOnce() {
    unsigned long now = millis();
    if (now - told_at_ > FORGETS_MS) is_configured_ = false;
    if (place_ && now > frame_ends_at_) place_ = 0;
    while (Serial.available()) {
      if (!accept(Serial.read(), now)) continue;
      if (topic_ == PUBLISHER) {
        announce();
        told_at_ = asked_at_ = now;
        return -1;
      }
      deliver(now);
    }
    if (is_configured_ && now - asked_at_ > TIME_EVERY_MS) {
      ask_time();
      asked_at_ = now;
    }
    return 0;
  }

 private:
  // Process a byte; return whether it completes a good frame.
  bool accept(uint8_t byte, unsigned long now) {
    uint16_t place = place_++;
    sum_ += byte;
    if (place == 0) {
      frame_ends_at_ = now + FRAME_MS;
      if (byte != 0xff) place_ = 0;
    } else if (place == 1 && byte != 0xfe) {
      place_ = 0;
      if (!is_configured_) ask_time();
    } else if (place == 2) {
      length_ = sum_ = byte;
    } else if (place == 3) {
      length_ += byte << 8;
    } else if (place == 4 && (sum_ != 0xff || length_ > SIZE)) {
      place_ = 0;
    } else if (place == 5) {
      topic_ = sum_ = byte;
    } else if (place == 6) {
      topic_ += byte << 8;
    } else if (place >= 7 && place < 7 + length_) {
      in_[place - 7] = byte;
    } else if (place >= 7) {
      place_ = 0;
      return sum_ == 0xff;
    }
    return false;
  }

  void deliver(unsigned long now) {
    if (topic_ == TIME) {
      told_at_ = now;
    } else if (topic_ == STOP) {
      is_configured_ = false;
    } else if (topic_ == PARAMETER) {
      uint32_t ints, floats;
      memcpy(&ints, in_, 4);
      memcpy(&floats, in_ + 4 + 4 * ints, 4);
      has_parameter_ = floats == 1;
      if (has_parameter_) memcpy(&parameter_, in_ + 8 + 4 * ints, 4);
    } else if (topic_ >= FIRST_TOPIC && topic_ - FIRST_TOPIC < subscribers_count_) {
      subscribers_[topic_ - FIRST_TOPIC]->receive(in_);
    }
  }

  void announce() {
    ask_time();
    for (uint8_t i = 0; i < publishers_count_; i++) {
      Publisher *one = publishers_[i];
      tell(one->kind, one->id, one->topic, one->message);
    }
    for (uint8_t i = 0; i < subscribers_count_; i++) {
      Receiver *one = subscribers_[i];
      tell(one->kind(), one->id, one->topic, one->blank());
    }
    is_configured_ = true;
  }

  void tell(int kind, uint16_t id, const char *topic, Msg *message) {
    unsigned char *out = out_ + 7;
    int32_t size = SIZE;
    memcpy(out, &id, 2);
    out += 2;
    out += put_text(out, topic);
    out += put_text(out, message->getType());
    out += put_text(out, message->getMD5());
    memcpy(out, &size, 4);
    send(kind, out + 4 - (out_ + 7));
  }

  void ask_time() {
    memset(out_ + 7, 0, 8);
    send(TIME, 8);
  }

  void log(uint8_t level, const char *text) {
    out_[7] = level;
    send(LOG, 1 + put_text(out_ + 8, text));
  }

  static uint16_t put_text(unsigned char *out, const char *text) {
    uint32_t length = strlen(text);
    memcpy(out, &length, 4);
    memcpy(out + 4, text, length);
    return 4 + length;
  }

  int send(uint16_t id, uint16_t length) {
    const uint8_t head[] = {0xff, 0xfe, (uint8_t)length, (uint8_t)(length >> 8),
                            (uint8_t)(255 - (length + (length >> 8))), (uint8_t)id,
                            (uint8_t)(id >> 8)};
    memcpy(out_, head, 7);
    uint8_t sum = 0;
    for (uint16_t i = 5; i < 7 + length; i++) sum += out_[i];
    out_[7 + length] = 255 - sum;
    Serial.write(out_, 8 + length);
    return 8 + length;
  }

  Hardware hardware_;
  Publisher *publishers_[TOPICS];
  Receiver *subscribers_[TOPICS];
  uint8_t publishers_count_ = 0, subscribers_count_ = 0, sum_ = 0;
  uint16_t place_ = 0, length_ = 0, topic_ = 0;
  unsigned char in_[SIZE], out_[SIZE + 8];
  bool is_configured_ = false, has_parameter_ = false;
  float parameter_ = 0;
  unsigned long told_at_ = 0, asked_at_ = 0, frame_ends_at_ = 0;
};

}  // namespace ros

#endif
