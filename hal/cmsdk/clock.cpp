#include <cstddef>

#include "swiftlet/hal/cmsdk_clock.hpp"

namespace swiftlet::hal {
namespace {

// Word offsets and bits: Arm DDI 0479, table 4-1.
constexpr std::size_t kControl = 0;
constexpr std::size_t kValue = 1;
constexpr std::size_t kReload = 2;
constexpr std::uint32_t kEnable = 1;
constexpr std::uint32_t kWholeRange = 0xFFFFFFFF;

}  // namespace

CmsdkClock::CmsdkClock(std::uintptr_t base, std::uint32_t clock_hz)
    : registers_(reinterpret_cast<volatile std::uint32_t*>(base)), ticks_per_microsecond_(clock_hz / 1'000'000) {
  registers_[kControl] = 0;
  registers_[kReload] = kWholeRange;
  registers_[kValue] = kWholeRange;
  registers_[kControl] = kEnable;
}

std::uint64_t CmsdkClock::ticks() {
  const std::uint32_t counted = kWholeRange - registers_[kValue];  // it counts down
  ticks_ += counted - latest_;                                     // modulo 2^32
  latest_ = counted;
  return ticks_;
}

std::chrono::microseconds CmsdkClock::now() {
  return std::chrono::microseconds(static_cast<std::int64_t>(ticks() / ticks_per_microsecond_));
}

}  // namespace swiftlet::hal
