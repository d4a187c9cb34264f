// Generator and process in one process, as two nodelets of one manager: messages between them go
// by pointer, and a thread of its own takes them. Usage: together RECORD
#include "answer.h"
#include "generate.h"

int main(int argc, char** argv)
{
  ros::init(argc, argv, "together");
  if (argc != 2)
    return 2;
  Answer answer;
  ros::AsyncSpinner spinner(1);
  spinner.start();
  generate(argv[1]);
  return 0;
}
