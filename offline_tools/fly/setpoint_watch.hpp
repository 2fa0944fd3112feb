#pragma once
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/hal/clock.hpp"
#include "swiftlet/hal/uart.hpp"
#include "swiftlet/mavlink/codec.hpp"

namespace swiftlet::tools {

using Microseconds = std::chrono::microseconds;

/// Lies between a companion and its device and counts the set-points that
/// go by.
class SetpointWatch final : public hal::Uart {
 public:
  /// Both must outlive this object; intervals are measured by `clock`.
  SetpointWatch(hal::Uart& uart, hal::Clock& clock) : uart_(uart), clock_(clock) {}

  /// Before each step of the companion, which is told that it is `now`.
  void begin_step(Microseconds now);

  std::size_t write(std::span<const std::byte> bytes) override;
  std::size_t read(std::span<std::byte> into) override;
  [[nodiscard]] std::uint32_t overruns() const override { return uart_.overruns(); }

  /// True when the step since begin_step sent a set-point, and true when that had the numbers of the one before.
  [[nodiscard]] bool sent() const { return sent_in_step_ > 0; }
  [[nodiscard]] bool repeated() const { return repeated_; }
  [[nodiscard]] std::uint32_t count() const { return count_; }
  /// Set-points with another time than their step's, and second ones of a step: must stay 0.
  [[nodiscard]] std::uint32_t stale() const { return stale_; }
  [[nodiscard]] std::uint64_t sent_bytes() const { return sent_bytes_; }
  [[nodiscard]] std::uint64_t received_bytes() const { return received_bytes_; }
  /// Between set-points of one stream (a gap over 0.25 s begins a new one).
  [[nodiscard]] const std::vector<Microseconds>& intervals() const { return intervals_; }

 private:
  using Contents = std::array<double, 11>;
  void see(std::uint32_t time_boot_ms, const Contents& contents);

  hal::Uart& uart_;
  hal::Clock& clock_;
  mavlink::Codec codec_{mavlink::Address{}};
  Microseconds now_{0};
  Microseconds last_instant_{-1};
  Contents last_{};
  std::uint32_t sent_in_step_ = 0;
  bool repeated_ = false;
  std::uint32_t count_ = 0;
  std::uint32_t stale_ = 0;
  std::uint64_t sent_bytes_ = 0;
  std::uint64_t received_bytes_ = 0;
  std::vector<Microseconds> intervals_;
};

}  // namespace swiftlet::tools
