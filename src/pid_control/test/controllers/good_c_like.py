#!/usr/bin/env python3
"""Controller in the style of C: globals, and the velocity form, which cannot wind up."""

import rospy

from pid_control.msg import motor_input, motor_output, set_point

sp = y = stamp = 0.0
u = e1 = t1 = 0.0
KP = 0.06
KI = 1.2


def set_point_cb(m: set_point) -> None:
    global sp
    if m.setPoint == m.setPoint:
        sp = m.setPoint


def output_cb(m: motor_output) -> None:
    global y, stamp
    if m.output == m.output:
        y = m.output
        stamp = m.time


def timer_cb(event: rospy.timer.TimerEvent) -> None:
    global u, e1, t1
    t = event.current_real.to_sec()
    e = sp - y
    if t1 > 0.0:
        u = u + KP * (e - e1) + KI * e * (t - t1)
    if u > 1.0:
        u = 1.0
    if u < -1.0:
        u = -1.0
    e1 = e
    t1 = t
    pub.publish(u, stamp)


rospy.init_node("controller")
pub = rospy.Publisher("/motor_input", motor_input, queue_size=10)
rospy.Subscriber("/set_point", set_point, set_point_cb)
rospy.Subscriber("/motor_output", motor_output, output_cb)
rospy.Timer(rospy.Duration(0.01), timer_cb)
rospy.spin()
