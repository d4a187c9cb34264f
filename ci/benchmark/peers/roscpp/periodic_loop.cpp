// The best periodic loop that plain C++ offers: absolute deadlines by clock_nanosleep.
// Usage: periodic_loop RECORD RATE SECONDS
#include <errno.h>

#include <cstdlib>

#include "record.h"

int main(int argc, char** argv)
{
  if (argc != 4)
    return 2;
  const double hz = std::atof(argv[2]);
  const long count = static_cast<long>(hz * std::atof(argv[3]));
  const long period = static_cast<long>(1e9 / hz);

  Record record(argv[1]);
  timespec deadline;
  clock_gettime(CLOCK_MONOTONIC, &deadline);
  for (long number = 0; number < count; ++number)
  {
    record.add(monotonic_now(), number / hz);
    deadline.tv_nsec += period;
    while (deadline.tv_nsec >= 1000000000L)
    {
      deadline.tv_nsec -= 1000000000L;
      ++deadline.tv_sec;
    }
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR)
    {
    }
  }
  return 0;
}
