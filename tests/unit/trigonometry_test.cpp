#include "swiftlet/trigonometry.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet_test.hpp"

namespace {

using swiftlet::angle_of;
using swiftlet::cosine;
using swiftlet::Real;
using swiftlet::sine;

constexpr Real kPi = std::numbers::pi_v<Real>;
constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();
constexpr Real kTolerance = sizeof(Real) == sizeof(double) ? Real(1e-15) : Real(3e-7);

/// A sum that depends on every bit of every number.
class Digest {
 public:
  void add(Real number) {
    const auto bits = std::bit_cast<std::uint64_t>(static_cast<double>(number));
    sum_ = (sum_ ^ bits) * 0x100000001B3;
  }
  [[nodiscard]] std::uint64_t sum() const { return sum_; }

 private:
  std::uint64_t sum_ = 0xCBF29CE484222325;
};

TEST(Trigonometry, AgreesWithTheLibraryToRounding) {
  for (int i = -2000; i <= 2000; ++i) {
    const Real angle = static_cast<Real>(i) * Real(0.0071);
    EXPECT_NEAR(sine(angle), std::sin(angle), kTolerance);
    EXPECT_NEAR(cosine(angle), std::cos(angle), kTolerance);
    const Real x = std::cos(angle) * 3;
    const Real y = std::sin(angle) * 3;
    EXPECT_NEAR(angle_of(y, x), std::atan2(y, x), kTolerance);
  }
  EXPECT_NEAR(sine(Real(123456)), std::sin(Real(123456)), Real(1e-6));
  EXPECT_NEAR(cosine(Real(-1e6)), std::cos(Real(1e6)), Real(1e-6));
}

TEST(Trigonometry, SmallAnglesKeepAllTheirDigits) {
  for (const Real angle : {Real(1e-3), Real(1e-9), Real(-1e-30)}) {
    EXPECT_NEAR(sine(angle) / angle, std::sin(angle) / angle, kTolerance);
    EXPECT_NEAR(angle_of(angle, 1) / angle, std::atan(angle) / angle, kTolerance);
  }
  EXPECT_EQ(sine(0), 0);
  EXPECT_EQ(cosine(0), 1);
}

TEST(Trigonometry, AxesAndQuadrantsAreThoseOfTheLibrary) {
  EXPECT_EQ(angle_of(0, 0), 0);
  EXPECT_EQ(angle_of(0, 2), 0);
  EXPECT_EQ(angle_of(0, -2), kPi);
  EXPECT_EQ(angle_of(Real(-0.0), -2), -kPi);
  EXPECT_EQ(angle_of(5, 0), kPi / 2);
  EXPECT_EQ(angle_of(-5, 0), -kPi / 2);
  EXPECT_NEAR(angle_of(1, 1), kPi / 4, kTolerance);
  EXPECT_NEAR(angle_of(1, -1), 3 * kPi / 4, kTolerance);
  EXPECT_NEAR(angle_of(-1, -1), -3 * kPi / 4, kTolerance);
}

TEST(Trigonometry, WhatIsNoNumberStaysNone) {
  EXPECT_TRUE(std::isnan(sine(kNan)));
  EXPECT_TRUE(std::isnan(cosine(kNan)));
  EXPECT_TRUE(std::isnan(angle_of(kNan, 1)));
  EXPECT_TRUE(std::isnan(angle_of(1, kNan)));
}

TEST(Trigonometry, GivesTheSameBitsOnEveryBoard) {
  Digest digest;
  for (int i = -5000; i <= 5000; ++i) {
    const Real angle = static_cast<Real>(i) * Real(0.0123);
    digest.add(sine(angle));
    digest.add(cosine(angle));
    digest.add(angle_of(static_cast<Real>(i), static_cast<Real>(i % 97)));
  }
  constexpr std::uint64_t kExpected =
      sizeof(Real) == sizeof(double) ? 7'890'539'028'343'465'163U : 4'277'212'639'351'819'511U;
  EXPECT_EQ(digest.sum(), kExpected);
}

}  // namespace
