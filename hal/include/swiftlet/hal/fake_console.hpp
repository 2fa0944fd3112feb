#pragma once
#include <algorithm>
#include <array>
#include <chrono>
#include <string_view>

#include "swiftlet/hal/console.hpp"
#include "swiftlet/hal/fake_clock.hpp"

namespace swiftlet::hal {

/// What a console's device does to who writes on it.
struct ConsoleFaults {
  std::chrono::microseconds byte_time{0};      ///< That the writer waits for each byte.
  std::chrono::microseconds stalled_until{0};  ///< The writer waits for this time of the clock first.
  bool full = false;                           ///< What is written is lost.
};

/// A console that keeps what is written, and lets its writer wait by moving the clock.
class FakeConsole final : public Console {
 public:
  explicit FakeConsole(FakeClock& clock) : clock_(clock) {}

  void write(std::span<const char> text) override {
    if (text.empty()) return;
    clock_.advance(std::max(faults_.stalled_until - clock_.now(), std::chrono::microseconds(0)));
    clock_.advance(faults_.byte_time * static_cast<int>(text.size()));
    const std::size_t count = faults_.full ? 0 : std::min(text.size(), bytes_.size() - size_);
    std::copy_n(text.begin(), count, bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += count;
    lost_ += text.size() - count;
  }

  /// May be changed at any time.
  ConsoleFaults& faults() { return faults_; }
  [[nodiscard]] std::string_view text() const { return {bytes_.data(), size_}; }
  [[nodiscard]] std::size_t lost() const { return lost_; }  ///< bytes for which there was no room

 private:
  FakeClock& clock_;
  ConsoleFaults faults_;
  std::array<char, 4096> bytes_{};
  std::size_t size_ = 0;
  std::size_t lost_ = 0;
};

}  // namespace swiftlet::hal
