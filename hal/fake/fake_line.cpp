#include "swiftlet/hal/fake_line.hpp"

#include <algorithm>

namespace swiftlet::hal {

FakeLine::FakeLine(Clock& clock, std::uint64_t seed)
    : end_a_(clock, a_to_b_, b_to_a_), end_b_(clock, b_to_a_, a_to_b_) {
  a_to_b_.random_state = seed;
  b_to_a_.random_state = ~seed;
}

std::size_t FakeLine::Direction::write(std::chrono::microseconds now, std::span<const std::byte> sent) {
  const std::size_t count = std::min(sent.size(), kCapacity - (written - taken));
  for (std::size_t i = 0; i < count; ++i) {
    if (faults.cut || random_ppm() < faults.drop_ppm) continue;
    std::byte byte = sent[i];
    if (random_ppm() < faults.corrupt_ppm) byte ^= static_cast<std::byte>(1U << (random_ppm() % 8U));
    bytes[written % kCapacity] = byte;
    readable_at[written % kCapacity] = static_cast<std::uint32_t>((now + faults.delay).count());
    ++written;
    if (faults.cut_after_bytes > 0 && --faults.cut_after_bytes == 0) faults.cut = true;
  }
  return count;
}

std::size_t FakeLine::Direction::read(std::chrono::microseconds now, std::span<std::byte> into) {
  deliver(now);
  const std::size_t count = std::min(into.size(), delivered - taken);
  for (std::size_t i = 0; i < count; ++i) into[i] = bytes[taken++ % kCapacity];
  return count;
}

void FakeLine::Direction::deliver(std::chrono::microseconds now) {
  if (now < faults.stalled_until) return;
  const auto passed = [this, now] {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(now.count()) - readable_at[delivered % kCapacity]) >= 0;
  };
  while (delivered < written && passed()) ++delivered;
  if (faults.receive_buffer == 0 || delivered - taken <= faults.receive_buffer) return;
  // The receiver keeps what came first: close the gap that the lost bytes leave.
  const std::size_t kept = taken + faults.receive_buffer;
  const std::size_t lost = delivered - kept;
  for (std::size_t i = delivered; i < written; ++i) {
    bytes[(i - lost) % kCapacity] = bytes[i % kCapacity];
    readable_at[(i - lost) % kCapacity] = readable_at[i % kCapacity];
  }
  written -= lost;
  delivered = kept;
  overruns += static_cast<std::uint32_t>(lost);
}

/// Uniform in [0, 10^6): splitmix64 (Steele, Lea, Flood, 2014), the same on every machine.
std::uint32_t FakeLine::Direction::random_ppm() {
  random_state += 0x9E3779B97F4A7C15;
  std::uint64_t z = random_state;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EB;
  return static_cast<std::uint32_t>((z ^ (z >> 31U)) % 1'000'000U);
}

}  // namespace swiftlet::hal
