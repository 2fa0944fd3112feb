#pragma once
#include <array>
#include <chrono>

#include "swiftlet/hal/clock.hpp"
#include "swiftlet/hal/uart.hpp"

namespace swiftlet::hal {

/// What goes wrong in one direction of a line. Probabilities are per byte, in parts of a million.
struct LineFaults {
  std::uint32_t drop_ppm = 0;
  std::uint32_t corrupt_ppm = 0;               ///< One bit of the byte is flipped.
  std::chrono::microseconds delay{0};          ///< From writing to being readable.
  std::chrono::microseconds stalled_until{0};  ///< Nothing is readable before this time of the clock.
  bool cut = false;                            ///< What is written is gone; the writer does not notice.
  std::uint32_t cut_after_bytes = 0;           ///< When not 0: the line cuts itself after so many more bytes.
  std::size_t receive_buffer = 0;              ///< When not 0: more unread bytes than this overrun and are lost.
};

/// A serial line in memory between `end_a` and `end_b`, whose faults are the same in every run with the same seed.
class FakeLine {
 public:
  FakeLine(Clock& clock, std::uint64_t seed);

  Uart& end_a() { return end_a_; }
  Uart& end_b() { return end_b_; }
  /// Faults of the bytes that a writes, and of those that b writes; may be changed at any time.
  LineFaults& a_to_b() { return a_to_b_.faults; }
  LineFaults& b_to_a() { return b_to_a_.faults; }

 private:
  struct Direction {
    static constexpr std::size_t kCapacity = 4096;  // what the writer's device holds, as a terminal of Linux

    std::size_t write(std::chrono::microseconds now, std::span<const std::byte> bytes);
    std::size_t read(std::chrono::microseconds now, std::span<std::byte> into);
    void deliver(std::chrono::microseconds now);
    std::uint32_t random_ppm();

    LineFaults faults;
    std::uint64_t random_state = 0;
    std::array<std::byte, kCapacity> bytes{};
    std::array<std::uint32_t, kCapacity> readable_at{};  // [us] modulo 2^32
    std::size_t written = 0;                             // bytes ever put in
    std::size_t delivered = 0;                           // bytes that reached the receiver, read or not
    std::size_t taken = 0;                               // bytes ever read
    std::uint32_t overruns = 0;
  };

  class End final : public Uart {
   public:
    End(Clock& clock, Direction& out, Direction& in) : clock_(clock), out_(out), in_(in) {}
    std::size_t write(std::span<const std::byte> bytes) override { return out_.write(clock_.now(), bytes); }
    std::size_t read(std::span<std::byte> into) override { return in_.read(clock_.now(), into); }
    [[nodiscard]] std::uint32_t overruns() const override { return in_.overruns; }

   private:
    Clock& clock_;
    Direction& out_;
    Direction& in_;
  };

  Direction a_to_b_;
  Direction b_to_a_;
  End end_a_;
  End end_b_;
};

}  // namespace swiftlet::hal
