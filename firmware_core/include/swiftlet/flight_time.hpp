#pragma once
#include <cstdint>

#include "swiftlet/types.hpp"

namespace swiftlet {

/// An instant of the caller's monotonic clock, or a difference of two [us]. Integers, because a float's seconds lose
/// milliseconds within hours.
using TimeUs = std::int64_t;

inline constexpr TimeUs kSecondUs = 1'000'000;

/// [us] to [s]; meant for differences.
constexpr Real to_seconds(TimeUs us) { return static_cast<Real>(us) / Real(kSecondUs); }

/// [s] to [us], cut towards zero.
constexpr TimeUs to_us(Real seconds) { return static_cast<TimeUs>(seconds * Real(kSecondUs)); }

}  // namespace swiftlet
