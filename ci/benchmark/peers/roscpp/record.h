// A record of samples: for each one its moment on the monotonic clock in s, and its value.
#pragma once

#include <time.h>

#include <fstream>
#include <string>
#include <vector>

inline double monotonic_now()
{
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

class Record
{
public:
  Record() { numbers_.reserve(1 << 20); }

  void add(double moment, double value)
  {
    numbers_.push_back(moment);
    numbers_.push_back(value);
  }

  void write(const std::string& file) const
  {
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(numbers_.data()), numbers_.size() * sizeof(double));
  }

private:
  std::vector<double> numbers_;
};
