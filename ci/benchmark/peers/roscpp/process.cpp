// The process node.
#include "answer.h"

int main(int argc, char** argv)
{
  ros::init(argc, argv, "process");
  Answer answer;
  ros::spin();
  return 0;
}
