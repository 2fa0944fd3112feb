#include "swiftlet/interior_knots.hpp"

#include "harness/random_corridor.hpp"
#include "swiftlet_test.hpp"

namespace swiftlet {
namespace {

constexpr Real kTolerance = sizeof(Real) == 8 ? Real(1e-12) : Real(1e-4);

/// Three boxes in a row along x; the legs are 5 m, 1 m and 12 m long.
struct Row {
  std::array<IntBox, 8> int_boxes{{{{0, 0, 0}, {5, 1, 1}}, {{5, 0, 0}, {6, 1, 1}}, {{6, 0, 0}, {18, 1, 1}}}};
  std::array<Box, 8> boxes;
  std::array<Box, 7> gates;
  std::array<Vector3, 9> points;

  Row() {
    const Real half = Real(0.5);
    for (std::size_t i = 0; i < 3; ++i) {
      for (Eigen::Index k = 0; k < 3; ++k) {
        boxes[i].lo[k] = int_boxes[i].lo[static_cast<std::size_t>(k)];
        boxes[i].hi[k] = int_boxes[i].hi[static_cast<std::size_t>(k)];
      }
    }
    gates[0] = {Vector3{5, 0, 0}, Vector3{5, 1, 1}};
    gates[1] = {Vector3{6, 0, 0}, Vector3{6, 1, 1}};
    points[0] = {0, half, half};
    points[1] = {5, half, half};
    points[2] = {6, half, half};
    points[3] = {18, half, half};
  }
  KnottedCorridor all() { return {int_boxes, boxes, gates, points}; }
};

TEST(InteriorKnots, LongLegsAreCutIntoEqualPiecesOfTheirBox) {
  Row row;
  ASSERT_EQ(insert_knots(row.all(), 3, 4), std::size_t{6});  // 2 + 1 + 3
  const std::array<Real, 7> x{0, Real(2.5), 5, 6, 10, 14, 18};
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(row.points[i][0], x[i], 1e-5);
  const std::array<bool, 5> knot{true, false, false, true, true};
  for (std::size_t k = 0; k < knot.size(); ++k) {
    EXPECT_EQ(is_knot(row.int_boxes, k), knot[k]);
    EXPECT_EQ(row.gates[k].lo == row.boxes[k].lo && row.gates[k].hi == row.boxes[k].hi, knot[k]);
  }
  EXPECT_EQ(row.gates[2].lo[0], Real(6));
  EXPECT_EQ(row.int_boxes[5].hi[0], 18);
}

TEST(InteriorKnots, ShortLegsStayWhole) {
  Row row;
  EXPECT_EQ(insert_knots(row.all(), 3, 12), std::size_t{3});
}

TEST(InteriorKnots, WithoutRoomTheCorridorStaysAsItIs) {
  Row row;
  KnottedCorridor tight = row.all();
  tight.boxes = tight.boxes.first(5);
  EXPECT_EQ(insert_knots(tight, 3, 4), std::size_t{3});
  EXPECT_EQ(row.points[3][0], Real(18));
  tight.boxes = row.all().boxes.first(6);
  EXPECT_EQ(insert_knots(tight, 3, 4), std::size_t{6});
}

TEST(InteriorKnots, PiecesOfASegmentAreTheSegment) {
  test::Random random(1);
  for (int run = 0; run < 50; ++run) {
    Segment segment;
    segment.duration = random.uniform(1, 2);
    for (auto& axis : segment.coefficients) {
      for (Real& c : axis) c = random.uniform(-1, 1);
    }
    std::array<Segment, 3> pieces;
    split_segment(segment, pieces);
    for (int i = 0; i <= 20; ++i) {
      const Real t = segment.duration * static_cast<Real>(i) / 20;
      const Sample whole = sample_segment(segment, t);
      const Sample split = sample_trajectory(pieces, t);
      EXPECT_LT((whole.position - split.position).norm(), 100 * kTolerance);
      EXPECT_LT((whole.velocity - split.velocity).norm(), 100 * kTolerance);
      EXPECT_LT((whole.jerk - split.jerk).norm(), 1000 * kTolerance);
    }
  }
}

}  // namespace
}  // namespace swiftlet
