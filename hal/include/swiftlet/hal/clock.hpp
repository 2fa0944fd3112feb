#pragma once
#include <chrono>

namespace swiftlet::hal {

/// Time since an arbitrary start, never going back.
class Clock {
 public:
  virtual std::chrono::microseconds now() = 0;

 protected:
  ~Clock() = default;  // protected and non-virtual: a public virtual one links operator delete
};

}  // namespace swiftlet::hal
