// A record of samples in a file that others read meanwhile: for each one its moment on the
// monotonic clock in s, and its value. See record.py.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>

inline double monotonic_now()
{
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

class Record
{
public:
  explicit Record(const char* file)
  {
    const int out = open(file, O_RDWR | O_CREAT | O_TRUNC, 0644);
    if (out < 0 || ftruncate(out, BYTES) != 0)
      std::abort();
    void* const memory = mmap(nullptr, BYTES, PROT_READ | PROT_WRITE, MAP_SHARED, out, 0);
    if (memory == MAP_FAILED)
      std::abort();
    close(out);
    next_ = static_cast<double*>(memory);
    end_ = next_ + ROOM;
  }

  void add(double moment, double value)
  {
    if (next_ == end_)
      std::abort();
    next_[1] = value;
    std::atomic_signal_fence(std::memory_order_release);
    next_[0] = moment;  // last, as it tells that the sample is there
    next_ += 2;
  }

private:
  static constexpr std::size_t ROOM = 1 << 20;
  static constexpr std::size_t BYTES = sizeof(double) * ROOM;

  double* next_;
  double* end_;
};
