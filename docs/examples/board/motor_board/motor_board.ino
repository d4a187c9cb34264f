// A motor with an encoder, for the controller of pid_control: motor_input in, motor_output out.
//
// ros.h comes from rosserial's Arduino library 0.7.8, the headers of the messages from
// "rosrun serial_link make_headers pid_control --arduino --into ~/Arduino/libraries".
// Pins as in the drawing beside this file.

#include <ros.h>
#include <ros_messages.h>

const uint8_t FORWARD_PIN = 7, BACKWARD_PIN = 8, PWM_PIN = 9;  // of the driver
const uint8_t A_PIN = 2, B_PIN = 3;                            // of the encoder; both interrupt
const uint8_t OUTPUTS[] = {FORWARD_PIN, BACKWARD_PIN, PWM_PIN}, INPUTS[] = {A_PIN, B_PIN};

const float COUNTS_PER_TURN = 1320.0;  // edges of both channels, gear included: see your motor
const unsigned long PERIOD_US = 10000;  // of motor_output: 100 Hz
const unsigned long SILENCE_MS = 500;   // after which the motor is stopped: the host may be gone

volatile long counts = 0;  // changed by interrupts
unsigned long heard_at = 0, measured_at = 0, began_at = 0;
long counts_before = 0;

void drive(float share) {
  share = constrain(share, -1.0, 1.0);
  digitalWrite(FORWARD_PIN, share > 0.0);
  digitalWrite(BACKWARD_PIN, share < 0.0);
  analogWrite(PWM_PIN, (int)(fabs(share) * 255.0 + 0.5));
}

void on_input(const pid_control::motor_input &message) {
  if (isnan(message.input)) return;
  drive(message.input);
  heard_at = millis();
}

// Each edge is a step one way or the other: whether A and B agree says which.
void on_a() { counts += digitalRead(A_PIN) == digitalRead(B_PIN) ? -1 : 1; }
void on_b() { counts += digitalRead(A_PIN) == digitalRead(B_PIN) ? 1 : -1; }

ros::NodeHandle host;
pid_control::motor_output output;
ros::Publisher output_publisher("motor_output", &output);
ros::Subscriber<pid_control::motor_input> input_subscriber("motor_input", on_input);

void setup() {
  for (uint8_t pin : OUTPUTS) pinMode(pin, OUTPUT);
  for (uint8_t pin : INPUTS) pinMode(pin, INPUT_PULLUP);
  drive(0.0);
  attachInterrupt(digitalPinToInterrupt(A_PIN), on_a, CHANGE);
  attachInterrupt(digitalPinToInterrupt(B_PIN), on_b, CHANGE);
  host.getHardware()->setBaud(115200);
  host.initNode();
  host.advertise(output_publisher);
  host.subscribe(input_subscriber);
  began_at = millis();
  measured_at = micros();
}

void publish_speed(unsigned long elapsed_us) {
  noInterrupts();  // a long is not read in one step
  long now = counts;
  interrupts();
  float turns = (now - counts_before) / COUNTS_PER_TURN;
  counts_before = now;
  output.output = turns * 2.0 * PI / (elapsed_us * 1e-6);
  output.time = (millis() - began_at) * 1e-3;
  output.status = turns == 0.0 ? "Motor Not Turning" : "Motor Turning";
  output_publisher.publish(&output);
}

void loop() {
  host.spinOnce();
  if (millis() - heard_at > SILENCE_MS) drive(0.0);
  unsigned long elapsed = micros() - measured_at;
  if (elapsed >= PERIOD_US) {
    measured_at += elapsed;
    publish_speed(elapsed);
  }
}
