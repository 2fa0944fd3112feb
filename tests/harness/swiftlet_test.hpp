#pragma once

/// TEST, EXPECT_ and ASSERT_ for tests that run on every machine: GoogleTest where there is a heap, otherwise the few
/// lines of bare_test.hpp under the same names. No fixtures, no `<<`.
#ifdef SWIFTLET_BARE_TEST
#include "bare_test.hpp"
#else
#include <gtest/gtest.h>
#endif

namespace swiftlet::test {

/// How many random cases a property test runs: full in host-release, a twentieth elsewhere.
inline constexpr int kPropertyRuns = SWIFTLET_PROPERTY_RUNS;

}  // namespace swiftlet::test
