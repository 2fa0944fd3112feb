#pragma once
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace swiftlet::mavlink {

/// No time that others stamp is believed beyond: 146 years after 1970. What is calculated with such times fits 64 bits.
inline constexpr std::chrono::nanoseconds kLatestTime{std::int64_t{1} << 62U};

/// The difference between two clocks from round trips: we ask at `sent`, the other side stamps `remote`, the answer is
/// here at `received`. Whatever the delays are, the true offset lies within half a round trip of the middle, so the
/// shortest of the latest round trips is the best, and two that contradict each other show a clock that was set.
class TimeSync {
 public:
  /// One round trip; `sent` and `received` of our clock. Ignored and counted when it cannot be true or contradicts the
  /// best one; three contradictions in a row start afresh from the last (the other side restarted, say).
  void add(std::chrono::nanoseconds sent, std::chrono::nanoseconds remote, std::chrono::nanoseconds received);
  void reset();

  /// From the fourth round trip on.
  [[nodiscard]] bool synchronised() const { return count_ >= 4; }
  [[nodiscard]] std::chrono::nanoseconds offset() const { return best_.offset; }  ///< Their clock minus ours.
  [[nodiscard]] std::chrono::nanoseconds round_trip() const { return best_.round_trip; }
  /// A time of their clock on ours.
  [[nodiscard]] std::chrono::microseconds to_ours(std::chrono::microseconds theirs) const;

  [[nodiscard]] std::uint32_t rejected() const { return rejected_; }
  [[nodiscard]] std::uint32_t restarts() const { return restarts_; }  ///< Because of contradictions.

 private:
  struct Sample {
    std::chrono::nanoseconds offset{0};
    std::chrono::nanoseconds round_trip{0};
  };
  void keep(const Sample& sample);

  std::array<Sample, 16> window_{};
  std::size_t count_ = 0;  // ever kept since the last start
  std::uint32_t contradictions_ = 0;
  std::uint32_t rejected_ = 0;
  std::uint32_t restarts_ = 0;
  Sample best_;
};

}  // namespace swiftlet::mavlink
