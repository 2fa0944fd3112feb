#pragma once
#include <cstddef>
#include <span>

namespace swiftlet::hal {

/// Where a board's text goes.
class Console {
 public:
  /// Writes all bytes; may wait for the device.
  virtual void write(std::span<const char> text) = 0;

 protected:
  ~Console() = default;  // protected and non-virtual: a public virtual one links operator delete
};

}  // namespace swiftlet::hal
