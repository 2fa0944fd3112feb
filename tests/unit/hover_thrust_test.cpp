#include "swiftlet/hover_thrust.hpp"

#include <limits>

#include "harness/random_corridor.hpp"
#include "swiftlet/flatness.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

/// A vehicle that hovers at `hover`, flown up and down for `seconds` with the estimate, thrust acting 40 ms late.
Real learned(Real hover, Real seconds) {
  HoverThrustEstimator estimator({});
  test::Random random(3);
  Real climb = 0;
  Real sent_before = estimator.hover();
  Real wanted = 0;
  for (int i = 0; i < static_cast<int>(seconds * 50); ++i) {
    if (i % 20 == 0) wanted = random.uniform(-1, 1);
    const Real sent = estimator.normalised(kGravity + wanted - climb);
    climb += (sent_before / hover * kGravity - kGravity) * Real(0.02);
    sent_before = sent;
    estimator.update(TimeUs{20'000} * i, climb + random.uniform(Real(-0.02), Real(0.02)), 1, sent);
  }
  return estimator.hover();
}

TEST(HoverThrust, LearnsFromClimbAndThrust) {
  EXPECT_NEAR(learned(Real(0.35), 20), 0.35, 0.02);
  EXPECT_NEAR(learned(Real(0.65), 20), 0.65, 0.03);
}

TEST(HoverThrust, StaysWithinItsBounds) {
  EXPECT_NEAR(learned(Real(0.05), 60), 0.1, 1e-6);
  EXPECT_NEAR(learned(Real(0.95), 60), 0.8, 0.05);
}

TEST(HoverThrust, MapsSpecificThrustToZeroToOne) {
  const HoverThrustEstimator estimator({});
  EXPECT_NEAR(estimator.normalised(kGravity), 0.5, 1e-6);
  EXPECT_EQ(estimator.normalised(-3), 0);
  EXPECT_EQ(estimator.normalised(100), 1);
  EXPECT_EQ(estimator.normalised(std::numeric_limits<Real>::quiet_NaN()), Real(0.5));
  EXPECT_EQ(estimator.normalised(std::numeric_limits<Real>::infinity()), Real(0.5));
}

TEST(HoverThrust, LearnsNothingFromNumbersThatAreNoneGapsOrAPause) {
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  HoverThrustEstimator estimator({});
  for (int i = 0; i < 200; ++i) {
    const TimeUs time = TimeUs{20'000} * i;
    switch (i % 4) {
      case 0:
        estimator.update(time, nan, 1, Real(0.9));
        break;
      case 1:
        estimator.update(time, 0, nan, Real(0.9));
        break;
      case 2:
        estimator.update(time, 0, 1, nan);
        break;
      default:
        estimator.update(time, 0, 1, Real(0.9));
    }
  }
  for (int i = 0; i < 100; ++i) estimator.update(20'000'000 + TimeUs{500'000} * i, 0, 1, Real(0.9));
  for (int i = 0; i < 100; ++i) {
    estimator.update(200'000'000 + TimeUs{20'000} * i, 0, 1, Real(0.9));
    if (i % 3 == 0) estimator.pause();
  }
  EXPECT_EQ(estimator.hover(), Real(0.5));
}

TEST(HoverThrust, BeginsWithWhatItIsToldUntilItHasLearnt) {
  HoverThrustEstimator estimator({});
  EXPECT_TRUE(estimator.begin_with(Real(0.3)));
  EXPECT_EQ(estimator.hover(), Real(0.3));
  EXPECT_TRUE(estimator.begin_with(Real(0.05)));
  EXPECT_EQ(estimator.hover(), Real(0.1));
  EXPECT_TRUE(estimator.begin_with(7));
  EXPECT_EQ(estimator.hover(), Real(0.8));
  EXPECT_FALSE(estimator.begin_with(std::numeric_limits<Real>::quiet_NaN()));
  EXPECT_EQ(estimator.hover(), Real(0.8));
  for (int i = 0; i < 10; ++i) estimator.update(TimeUs{20'000} * i, 0, 1, Real(0.4));
  const Real learnt = estimator.hover();
  EXPECT_LT(learnt, Real(0.8));
  EXPECT_FALSE(estimator.begin_with(Real(0.3)));
  EXPECT_EQ(estimator.hover(), learnt);
}

TEST(HoverThrust, TiltCountsOnlyItsVerticalPart) {
  HoverThrustEstimator estimator({});
  for (int i = 0; i < 1000; ++i) estimator.update(TimeUs{20'000} * i, 0, Real(0.8), Real(0.5));
  EXPECT_NEAR(estimator.hover(), 0.4, 1e-3);
}

}  // namespace
}  // namespace swiftlet
