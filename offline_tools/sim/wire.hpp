#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "sim/noise.hpp"

namespace swiftlet::tools {

/// What is wrong with a wire at the moment.
struct WireFaults {
  double corrupt = 0;  ///< share of the bytes
  double loss = 0;     ///< share of the messages
  bool stalled = false;
  bool cut = false;
};

/// One direction of a link: delays, loses, changes, holds back or ends what is sent. Seeded.
class Wire {
 public:
  using Microseconds = std::chrono::microseconds;
  Wire(Microseconds delay, std::uint64_t seed) : delay_(delay), noise_(seed) {}

  void set_faults(const WireFaults& faults);
  /// One message, or whatever counts as one.
  void send(std::span<const std::byte> message, Microseconds now);
  /// Everything that has arrived by now.
  std::vector<std::byte> receive(Microseconds now);
  [[nodiscard]] std::uint64_t sent_bytes() const { return sent_bytes_; }

 private:
  struct Parcel {
    Microseconds due;
    std::vector<std::byte> bytes;
  };

  Microseconds delay_;
  Noise noise_;
  WireFaults faults_;
  std::size_t bytes_until_cut_ = 0;
  std::deque<Parcel> under_way_;
  std::uint64_t sent_bytes_ = 0;
};

}  // namespace swiftlet::tools
