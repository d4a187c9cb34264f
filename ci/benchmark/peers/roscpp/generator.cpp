// The signal generator. Usage: generator RECORD
#include "generate.h"

int main(int argc, char** argv)
{
  ros::init(argc, argv, "signal_generator");
  if (argc != 2)
    return 2;
  generate(argv[1]);
  return 0;
}
