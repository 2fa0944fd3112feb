#pragma once
#include <algorithm>
#include <vector>

#include "sim/pixhawk_sim.hpp"
#include "swiftlet/hal/uart.hpp"

namespace swiftlet::tools {

/// The companion's device in lock-step: what it writes reaches the simulated autopilot, and `advance` brings what that
/// sends.
class LockstepUart final : public hal::Uart {
 public:
  /// `sim` must outlive this object.
  explicit LockstepUart(PixhawkSim& sim) : sim_(sim) {}

  std::size_t write(std::span<const std::byte> bytes) override {
    sim_.receive(bytes);
    return bytes.size();
  }
  std::size_t read(std::span<std::byte> into) override {
    const std::size_t count = std::min(into.size(), waiting_.size());
    std::copy_n(waiting_.begin(), count, into.begin());
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }

  void advance(Microseconds duration) {
    const std::vector<std::byte> bytes = sim_.step(duration);
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  }

 private:
  PixhawkSim& sim_;
  std::vector<std::byte> waiting_;
};

}  // namespace swiftlet::tools
