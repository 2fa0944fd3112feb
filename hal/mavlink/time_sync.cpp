#include "swiftlet/mavlink/time_sync.hpp"

#include <algorithm>

namespace swiftlet::mavlink {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kLongestRoundTrip = std::chrono::seconds(1);
constexpr nanoseconds kDriftAllowance = std::chrono::milliseconds(1);  // 300 ppm over the window at five a second
constexpr std::uint32_t kMaxContradictions = 3;

}  // namespace

void TimeSync::add(nanoseconds sent, nanoseconds remote, nanoseconds received) {
  const nanoseconds round_trip = received - sent;
  const bool believable = remote >= nanoseconds(0) && remote <= kLatestTime;
  if (!believable || round_trip < nanoseconds(0) || round_trip > kLongestRoundTrip) {
    ++rejected_;
    return;
  }
  const Sample sample{remote - sent - round_trip / 2, round_trip};
  const nanoseconds apart = std::chrono::abs(sample.offset - best_.offset);
  if (count_ > 0 && apart > (sample.round_trip + best_.round_trip) / 2 + kDriftAllowance) {
    ++rejected_;
    if (++contradictions_ < kMaxContradictions) return;
    reset();
    ++restarts_;
  }
  contradictions_ = 0;
  keep(sample);
}

void TimeSync::reset() {
  count_ = 0;
  contradictions_ = 0;
}

std::chrono::microseconds TimeSync::to_ours(std::chrono::microseconds theirs) const {
  return theirs - std::chrono::duration_cast<std::chrono::microseconds>(best_.offset);
}

void TimeSync::keep(const Sample& sample) {
  window_[count_++ % window_.size()] = sample;
  const auto end = window_.begin() + static_cast<std::ptrdiff_t>(std::min(count_, window_.size()));
  best_ = *std::min_element(window_.begin(), end,
                            [](const Sample& a, const Sample& b) { return a.round_trip < b.round_trip; });
}

}  // namespace swiftlet::mavlink
