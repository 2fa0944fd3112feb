#pragma once
#include <gtest/gtest.h>

namespace swiftlet::test {
/// How many random cases a property test runs: full in host-release, a twentieth elsewhere.
inline constexpr int kPropertyRuns = SWIFTLET_PROPERTY_RUNS;
}  // namespace swiftlet::test
