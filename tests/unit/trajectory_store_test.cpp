#include "swiftlet/trajectory_store.hpp"

#include <limits>

#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr TimeUs kNow = 1'700'000'000'000'000;  // float must not lose anything to large clocks
constexpr TimeUs kLatency = 50'000;
constexpr Real kTolerance = sizeof(Real) == 8 ? Real(1e-9) : Real(1e-4);

/// From `x0` to `x0` + 4 m along x, rest to rest in 4 s.
Segment leg_from(Real x0) {
  Segment leg;
  leg.duration = 4;
  leg.coefficients[0] = {x0, 0, 0, Real(40) / 64, Real(-60) / 256, Real(24) / 1024};
  return leg;
}

/// From a state along x to rest at 6 m, in 4 s.
Segment leg_from(const State& state) {
  const Real T = 4;
  const Real p = state.position[0];
  const Real v = state.velocity[0];
  const Real a = state.acceleration[0];
  const Real d = 6 - p - v * T - a * T * T / 2;
  const Real dv = -v - a * T;
  const Real da = -a;
  Segment leg;
  leg.duration = T;
  leg.coefficients[0] = {p,
                         v,
                         a / 2,
                         (10 * d - 4 * dv * T + da * T * T / 2) / (T * T * T),
                         (-15 * d + 7 * dv * T - da * T * T) / (T * T * T * T),
                         (6 * d - 3 * dv * T + da * T * T / 2) / (T * T * T * T * T)};
  return leg;
}

PlanOffer offer_of(const Segment& segment) {
  PlanOffer offer;
  offer.segments = {&segment, 1};
  offer.certificate.pass = true;
  offer.limits.a_max = Vector3::Constant(2);
  return offer;
}

/// A store that flies leg_from(0) from kNow on.
struct Flying {
  TrajectorySlots<2> memory;
  TrajectoryStore store{memory.spans()};
  Segment first = leg_from(Real(0));

  Flying() {
    store.hold(Vector3::Zero(), kNow - kLatency);
    const Splice splice = store.begin(kNow - kLatency, kLatency);
    EXPECT_EQ(store.offer(offer_of(first), splice, kNow - kLatency), OfferResult::kAccepted);
  }
};

TEST(TrajectoryStore, HasNothingToFlyAtFirst) {
  TrajectorySlots<2> memory;
  TrajectoryStore store(memory.spans());
  EXPECT_FALSE(store.has_reference());
  EXPECT_EQ(store.begin(kNow, kLatency).id, 0U);
}

TEST(TrajectoryStore, HoldsAPointUntilThePlanStarts) {
  Flying flying;
  EXPECT_NEAR(flying.store.sample(kNow - 1).position[0], 0, kTolerance);
  EXPECT_EQ(flying.store.sample(kNow - 1).velocity.norm(), 0);
  EXPECT_FALSE(flying.store.at_rest(kNow - 1));
}

TEST(TrajectoryStore, SamplesPositionToJerkAndHoldsAfterTheEnd) {
  Flying flying;
  const Sample middle = flying.store.sample(kNow + 2 * kSecondUs);
  EXPECT_NEAR(middle.position[0], 2, kTolerance);
  EXPECT_NEAR(middle.velocity[0], 1.875, kTolerance);
  EXPECT_NEAR(middle.acceleration[0], 0, 10 * kTolerance);
  EXPECT_NEAR(middle.jerk[0], 6 * (40.0 / 64) - 24 * (60.0 / 256) * 2 + 60 * (24.0 / 1024) * 4, 1e-3);
  EXPECT_FALSE(flying.store.at_rest(kNow + 2 * kSecondUs));
  const Sample after = flying.store.sample(kNow + 100 * kSecondUs);
  EXPECT_NEAR(after.position[0], 4, kTolerance);
  EXPECT_EQ(after.velocity.norm(), 0);
  EXPECT_EQ(after.acceleration.norm(), 0);
  EXPECT_EQ(after.jerk.norm(), 0);
  EXPECT_TRUE(flying.store.at_rest(kNow + 100 * kSecondUs));
}

TEST(TrajectoryStore, SplicesANewPlanIntoTheMovingOneWithoutAJump) {
  Flying flying;
  const TimeUs now = kNow + 1'300'000;
  const Splice splice = flying.store.begin(now, kLatency);
  EXPECT_EQ(splice.start, now + kLatency);
  const Segment second = leg_from(splice.state);
  EXPECT_EQ(flying.store.offer(offer_of(second), splice, now + 9'000), OfferResult::kAccepted);
  const Sample before = flying.store.sample(splice.start - 1);
  const Sample after = flying.store.sample(splice.start);
  EXPECT_NEAR(before.position[0], after.position[0], 1e-4);
  EXPECT_NEAR(before.velocity[0], after.velocity[0], 1e-3);
  EXPECT_NEAR(before.acceleration[0], after.acceleration[0], 1e-2);
  EXPECT_NEAR(flying.store.sample(splice.start - 10'000).position[0],
              sample_segment(flying.first, Real(1.34)).position[0], kTolerance);
  EXPECT_NEAR(flying.store.sample(splice.start + 100 * kSecondUs).position[0], 6, 1e-3);
}

TEST(TrajectoryStore, AResultThatComesTooLateIsDiscarded) {
  Flying flying;
  const TimeUs now = kNow + kSecondUs;
  const Splice splice = flying.store.begin(now, kLatency);
  const Segment second = leg_from(splice.state);
  EXPECT_EQ(flying.store.offer(offer_of(second), splice, now + kLatency + 1), OfferResult::kLate);
  EXPECT_NEAR(flying.store.sample(kNow + 100 * kSecondUs).position[0], 4, kTolerance);
}

TEST(TrajectoryStore, NothingWithoutAPassingCertificateIsFlown) {
  Flying flying;
  const Splice splice = flying.store.begin(kNow, kLatency);
  const Segment second = leg_from(splice.state);
  PlanOffer offer = offer_of(second);
  offer.certificate.pass = false;
  EXPECT_EQ(flying.store.offer(offer, splice, kNow), OfferResult::kNotCertified);
  EXPECT_NEAR(flying.store.sample(kNow + 100 * kSecondUs).position[0], 4, kTolerance);
}

TEST(TrajectoryStore, ASpliceIsGoodForOneOfferOfTheNewestKind) {
  Flying flying;
  const TimeUs now = kNow + 1;
  const Splice old = flying.store.begin(now, kLatency);
  const Splice splice = flying.store.begin(now, kLatency);
  const Segment second = leg_from(splice.state);
  EXPECT_EQ(flying.store.offer(offer_of(second), old, now), OfferResult::kSuperseded);
  EXPECT_EQ(flying.store.offer(offer_of(second), Splice{}, now), OfferResult::kSuperseded);
  EXPECT_EQ(flying.store.offer(offer_of(second), splice, now), OfferResult::kAccepted);
  EXPECT_EQ(flying.store.offer(offer_of(second), splice, now), OfferResult::kSuperseded);
}

TEST(TrajectoryStore, ARefusedOfferIsNotOfferedAgain) {
  Flying flying;
  const Splice splice = flying.store.begin(kNow + 1, kLatency);
  const Segment second = leg_from(splice.state);
  PlanOffer offer = offer_of(second);
  offer.segments = {};
  EXPECT_EQ(flying.store.offer(offer, splice, kNow), OfferResult::kTooLong);
  EXPECT_EQ(flying.store.offer(offer_of(second), splice, kNow), OfferResult::kSuperseded);
}

TEST(TrajectoryStore, RefusesToBeginWhileACandidateWaits) {
  Flying flying;
  const Splice splice = flying.store.begin(kNow + 1, kLatency);
  const Segment second = leg_from(splice.state);
  EXPECT_EQ(flying.store.offer(offer_of(second), splice, kNow + 2), OfferResult::kAccepted);
  EXPECT_EQ(flying.store.begin(kNow + 3, kLatency).id, 0U);
  EXPECT_NE(flying.store.begin(splice.start, kLatency).id, 0U);
}

TEST(TrajectoryStore, RefusesMoreSegmentsThanASlotHolds) {
  Flying flying;
  const Splice splice = flying.store.begin(kNow, kLatency);
  std::array<Segment, 3> segments{leg_from(splice.state), leg_from(Real(6)), leg_from(Real(10))};
  PlanOffer offer = offer_of(segments[0]);
  offer.segments = segments;
  EXPECT_EQ(flying.store.offer(offer, splice, kNow), OfferResult::kTooLong);
}

TEST(TrajectoryStore, RefusesAJumpAtTheStartAndMotionAtTheEnd) {
  for (const std::size_t term : {0, 1, 2}) {
    Flying flying;
    const Splice splice = flying.store.begin(kNow + kSecondUs, kLatency);
    Segment second = leg_from(splice.state);
    second.coefficients[1][term] += Real(0.02);
    EXPECT_EQ(flying.store.offer(offer_of(second), splice, kNow + kSecondUs), OfferResult::kDiscontinuous);
  }
  Flying flying;
  const Splice splice = flying.store.begin(kNow + kSecondUs, kLatency);
  Segment second = leg_from(splice.state);
  second.duration = 3;
  EXPECT_EQ(flying.store.offer(offer_of(second), splice, kNow + kSecondUs), OfferResult::kDiscontinuous);
  const Splice again = flying.store.begin(kNow + kSecondUs, kLatency);
  second = leg_from(again.state);
  second.coefficients[2][0] = std::numeric_limits<Real>::quiet_NaN();
  EXPECT_EQ(flying.store.offer(offer_of(second), again, kNow + kSecondUs), OfferResult::kDiscontinuous);
}

TEST(TrajectoryStore, BrakesAlongTheCommittedPathAndHolds) {
  Flying flying;
  const TimeUs now = kNow + 1'700'000;
  const Sample before = flying.store.sample(now);
  flying.store.brake(now);
  const Sample after = flying.store.sample(now);
  EXPECT_NEAR(before.position[0], after.position[0], kTolerance);
  EXPECT_NEAR(before.velocity[0], after.velocity[0], kTolerance);
  EXPECT_NEAR(before.acceleration[0], after.acceleration[0], 10 * kTolerance);
  TimeUs stopped = now;
  while (!flying.store.at_rest(stopped) && stopped < now + 5 * kSecondUs) stopped += 10'000;
  EXPECT_LT(stopped, now + 3 * kSecondUs);
  const Sample rest = flying.store.sample(stopped);
  EXPECT_EQ(rest.velocity.norm(), 0);
  EXPECT_LT(rest.position[0], Real(3.9));
  EXPECT_EQ(flying.store.sample(stopped + 50 * kSecondUs).position[0], rest.position[0]);
}

TEST(TrajectoryStore, ASecondBrakeChangesNothing) {
  Flying flying;
  flying.store.brake(kNow + kSecondUs);
  const Real x = flying.store.sample(kNow + 2 * kSecondUs).position[0];
  flying.store.brake(kNow + 1'100'000);
  EXPECT_EQ(flying.store.sample(kNow + 2 * kSecondUs).position[0], x);
}

TEST(TrajectoryStore, ABrakeDropsTheWaitingCandidateAndPlansUnderWay) {
  Flying flying;
  const TimeUs now = kNow + kSecondUs;
  const Splice splice = flying.store.begin(now, kLatency);
  const Segment second = leg_from(splice.state);
  EXPECT_EQ(flying.store.offer(offer_of(second), splice, now), OfferResult::kAccepted);
  flying.store.brake(now + 1'000);
  EXPECT_LT(flying.store.sample(kNow + 100 * kSecondUs).position[0], 4);
  const Splice braked = flying.store.begin(now + 2'000, kLatency);
  flying.store.hold(Vector3::Ones(), now + 3'000);
  EXPECT_EQ(flying.store.offer(offer_of(second), braked, now + 3'000), OfferResult::kSuperseded);
}

TEST(TrajectoryStore, ReplansFromABrakeUnderWay) {
  Flying flying;
  const TimeUs now = kNow + 1'500'000;
  flying.store.brake(now);
  const Splice splice = flying.store.begin(now + 200'000, kLatency);
  EXPECT_GT(splice.state.velocity[0], 0);
  const Segment second = leg_from(splice.state);
  EXPECT_EQ(flying.store.offer(offer_of(second), splice, now + 210'000), OfferResult::kAccepted);
  EXPECT_NEAR(flying.store.sample(kNow + 100 * kSecondUs).position[0], 6, 1e-3);
}

TEST(TrajectoryStore, AClockJumpDoesNotMoveTheReference) {
  for (const TimeUs jump : {-3'000 * kSecondUs, 5 * kSecondUs}) {
    Flying flying;
    const Real x = flying.store.sample(kNow + kSecondUs).position[0];
    flying.store.shift_clock(jump);
    EXPECT_EQ(flying.store.sample(kNow + kSecondUs + jump).position[0], x);
  }
}

TEST(TrajectoryStore, APositionJumpCarriesTheReferenceAlong) {
  Flying flying;
  const Real x = flying.store.sample(kNow + kSecondUs).position[0];
  flying.store.shift_position({Real(0.5), 1, 0});
  EXPECT_NEAR(flying.store.sample(kNow + kSecondUs).position[0], x + Real(0.5), kTolerance);
  EXPECT_NEAR(flying.store.sample(kNow + 100 * kSecondUs).position[1], 1, kTolerance);
}

TEST(TrajectoryStore, DescribesEveryResult) {
  for (const OfferResult result : {OfferResult::kAccepted, OfferResult::kLate, OfferResult::kSuperseded,
                                   OfferResult::kNotCertified, OfferResult::kTooLong, OfferResult::kDiscontinuous}) {
    EXPECT_NE(describe(result)[0], '\0');
    EXPECT_NE(describe(result)[0], 'u');
  }
}

}  // namespace
}  // namespace swiftlet
