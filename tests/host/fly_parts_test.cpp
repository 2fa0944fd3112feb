// What `swiftlet fly` is made of, where a flight would not show it.
#include <gtest/gtest.h>

#include "fly/flight_fault.hpp"
#include "fly/floor.hpp"
#include "fly/setpoint_watch.hpp"
#include "swiftlet/hal/fake_clock.hpp"
#include "unit/test_blob.hpp"

namespace swiftlet::tools {
namespace {

using std::chrono::milliseconds;

TEST(FlightFault, KnowsTheFaultsOfBothSides) {
  const auto far = parse_flight_fault("cut@2.5");
  ASSERT_TRUE(far && std::holds_alternative<Fault>(*far));
  EXPECT_EQ(begin_of(*far), 2.5);
  const auto near = parse_flight_fault("sleep@3+0.75");
  ASSERT_TRUE(near && std::holds_alternative<CompanionFault>(*near));
  EXPECT_EQ(std::get<CompanionFault>(*near).duration, 0.75);
  EXPECT_EQ(std::get<CompanionFault>(*parse_flight_fault("sleep@3")).duration, 0.5);
  EXPECT_STREQ(describe(*parse_flight_fault("map-replaced@3")), "map-replaced");
  for (const char* bad :
       {"", "@", "sleep", "sleep@", "sleep@x", "sleep@-1", "clock-step@1+1", "nothing@1", "cut@1e400"}) {
    EXPECT_FALSE(parse_flight_fault(bad)) << bad;
  }
}

/// A room of 4 x 4 x 3 m whose lowest free height is 1 m.
test::TestBlob blob{{4, 4, 3}, {{{0, 0, 1}, {4, 4, 3}}}};

TEST(Floor, APadLiesAMetreBelowTheStartOrAsDeepAsTheMapAllows) {
  const BoxGraphView map = blob.view();
  const double radius = map.header().radius;
  EXPECT_EQ(Floor(map, {}, {2, 2, 2.5}).pad(), Vector3(2, 2, 1.5));
  EXPECT_NEAR(Floor(map, {}, {2, 2, 1.5}).pad().z(), 1 - radius, 0.011);
  const Box table{{1, 1, 0}, {3, 3, 1.25}};
  EXPECT_EQ(Floor(map, {table}, {2, 2, 1.5}).pad(), Vector3(2, 2, 1.25));
}

TEST(Floor, IsThePadTheHighestObstacleBelowOrAMetreBelowTheMap) {
  Floor floor(blob.view(), {{{1, 1, 0}, {3, 3, 1}}, {{1, 1, 0}, {3, 3, 0.5}}, {{1, 1, 2}, {3, 3, 3}}}, {0.5, 0.5, 2});
  EXPECT_EQ(floor.below({0.5, 0.5, 2}), floor.pad().z());
  EXPECT_EQ(floor.below({0.5, 0.5, 0.1}), -1);  // under the pad
  floor.remove_pad();
  EXPECT_EQ(floor.below({0.5, 0.5, 2}), -1);
  EXPECT_EQ(floor.below({2, 2, 1.5}), 1);
  EXPECT_EQ(floor.below({2, 2, 1}), 1);  // standing on it
  EXPECT_EQ(floor.below({2, 2, 0.7}), 0.5);
  EXPECT_EQ(floor.below({3.5, 3.5, 2}), -1);
  EXPECT_EQ(floor.below({3.5, 3.5, -2}), -2);  // nothing is below the map
}

class Sink final : public hal::Uart {
 public:
  std::size_t write(std::span<const std::byte> bytes) override { return std::min(bytes.size(), room); }
  std::size_t read(std::span<std::byte> /*into*/) override { return 0; }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }
  std::size_t room = 1000;
};

struct Watched {
  Sink sink;
  hal::FakeClock clock;
  SetpointWatch watch{sink, clock};
  mavlink::Codec codec{mavlink::Address{1, 195}};

  /// A set-point made at `made` is sent in a step at the clock's time.
  void send(milliseconds made, float yaw) {
    mavlink::SetPositionTarget target;
    target.time_boot_ms = static_cast<std::uint32_t>(made.count());
    target.yaw = yaw;
    (void)watch.write(codec.encode(target));
  }
  void step() {
    clock.advance(milliseconds(10));
    watch.begin_step(clock.now());
  }
};

TEST(SetpointWatch, FreshSetpointsAreNeitherStaleNorRepeated) {
  Watched watched;
  for (int i = 1; i <= 5; ++i) {
    watched.step();
    EXPECT_FALSE(watched.watch.sent());
    watched.send(milliseconds(10 * i), static_cast<float>(i));
    EXPECT_TRUE(watched.watch.sent());
    EXPECT_FALSE(watched.watch.repeated());
  }
  EXPECT_EQ(watched.watch.count(), 5U);
  EXPECT_EQ(watched.watch.stale(), 0U);
  ASSERT_EQ(watched.watch.intervals().size(), 4U);
  EXPECT_EQ(watched.watch.intervals()[0], milliseconds(10));
}

TEST(SetpointWatch, AnOldOneASecondOneAndARepetitionAreSeen) {
  Watched watched;
  watched.step();
  watched.send(milliseconds(10), 1);
  watched.send(milliseconds(10), 2);  // a second one
  EXPECT_EQ(watched.watch.stale(), 1U);
  watched.step();
  watched.send(milliseconds(10), 3);  // of the step before
  EXPECT_EQ(watched.watch.stale(), 2U);
  watched.step();
  watched.send(milliseconds(30), 3);
  EXPECT_TRUE(watched.watch.repeated());
  EXPECT_EQ(watched.watch.stale(), 2U);
}

TEST(SetpointWatch, CountsWhatTheDeviceTookAlone) {
  Watched watched;
  watched.sink.room = 20;
  watched.step();
  watched.send(milliseconds(10), 1);
  EXPECT_EQ(watched.watch.count(), 0U);
  EXPECT_EQ(watched.watch.sent_bytes(), 20U);
}

}  // namespace
}  // namespace swiftlet::tools
