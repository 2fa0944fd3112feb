#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace swiftlet::hal {

/// A byte stream in both directions; neither call ever blocks.
class Uart {
 public:
  /// Takes the first bytes for which the device has room; returns how many.
  virtual std::size_t write(std::span<const std::byte> bytes) = 0;

  /// Moves received bytes to the front of `into`; returns how many, 0 when none wait.
  virtual std::size_t read(std::span<std::byte> into) = 0;

  /// Received bytes that were lost because nobody read them in time, as far as the device can tell.
  [[nodiscard]] virtual std::uint32_t overruns() const = 0;

 protected:
  ~Uart() = default;  // protected and non-virtual: a public virtual one links operator delete
};

}  // namespace swiftlet::hal
