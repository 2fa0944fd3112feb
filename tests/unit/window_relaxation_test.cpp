#include "swiftlet/window_relaxation.hpp"

#include <array>
#include <span>

#include "swiftlet_test.hpp"

namespace {

using swiftlet::IntBox;
using swiftlet::relax_windows;
using swiftlet::Relaxation;

// Cells of an octree in the plane, one unit high: L is 4 x 4, S is 2 x 2. "Entry" and "exit" are those of the middle
// cell.

TEST(WindowRelaxation, Case1SmallToLargeAfterForwardGoesForwardAgain) {
  std::array<IntBox, 3> cells{IntBox{{0, 0, 0}, {1, 1, 1}}, IntBox{{1, 0, 0}, {3, 2, 1}}, IntBox{{3, 0, 0}, {7, 4, 1}}};
  std::array<Relaxation, 2> decisions{};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kForward);
  EXPECT_EQ(decisions[1], Relaxation::kForward);
  EXPECT_EQ(cells[0], (IntBox{{0, 0, 0}, {3, 1, 1}}));
  EXPECT_EQ(cells[1], (IntBox{{1, 0, 0}, {7, 2, 1}}));
  EXPECT_EQ(cells[2], (IntBox{{3, 0, 0}, {7, 4, 1}}));
}

TEST(WindowRelaxation, Case2LargeToSmallAfterForwardGoesBackwardSoBothGatesLieInTheLargeCell) {
  std::array<IntBox, 3> cells{IntBox{{0, 0, 0}, {2, 2, 1}}, IntBox{{2, 0, 0}, {6, 4, 1}}, IntBox{{6, 2, 0}, {8, 4, 1}}};
  std::array<Relaxation, 2> decisions{};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kForward);
  EXPECT_EQ(decisions[1], Relaxation::kBackward);
  EXPECT_EQ(cells[0], (IntBox{{0, 0, 0}, {6, 2, 1}}));
  EXPECT_EQ(cells[1], (IntBox{{2, 0, 0}, {6, 4, 1}}));
  EXPECT_EQ(cells[2], (IntBox{{2, 2, 0}, {8, 4, 1}}));
}

TEST(WindowRelaxation, Case3LargeToSmallAfterBackwardGoesBackwardAgain) {
  std::array<IntBox, 3> cells{IntBox{{0, 0, 0}, {4, 4, 1}}, IntBox{{4, 0, 0}, {6, 2, 1}}, IntBox{{6, 0, 0}, {7, 1, 1}}};
  std::array<Relaxation, 2> decisions{};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kBackward);
  EXPECT_EQ(decisions[1], Relaxation::kBackward);
  EXPECT_EQ(cells[1], (IntBox{{0, 0, 0}, {6, 2, 1}}));
  EXPECT_EQ(cells[2], (IntBox{{4, 0, 0}, {7, 1, 1}}));
}

TEST(WindowRelaxation, Case4SmallToLargeAfterNoRelaxationGoesForward) {
  // The first window is crossed by neither face: 2 wide and 1 high against 1 wide and 2 high.
  std::array<IntBox, 3> cells{IntBox{{0, 0, 0}, {2, 2, 1}}, IntBox{{2, 0, 0}, {4, 1, 2}}, IntBox{{4, 0, 0}, {8, 4, 4}}};
  std::array<Relaxation, 2> decisions{};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kNone);
  EXPECT_EQ(decisions[1], Relaxation::kForward);
  EXPECT_EQ(cells[0], (IntBox{{0, 0, 0}, {2, 2, 1}}));
  EXPECT_EQ(cells[1], (IntBox{{2, 0, 0}, {8, 1, 2}}));
}

TEST(WindowRelaxation, Case5LargeToSmallAfterNoRelaxationGoesBackward) {
  std::array<IntBox, 3> cells{IntBox{{0, 0, 0}, {2, 2, 1}}, IntBox{{2, 0, 0}, {4, 1, 2}}, IntBox{{4, 0, 0}, {5, 1, 1}}};
  std::array<Relaxation, 2> decisions{};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kNone);
  EXPECT_EQ(decisions[1], Relaxation::kBackward);
  EXPECT_EQ(cells[2], (IntBox{{2, 0, 0}, {5, 1, 1}}));
}

TEST(WindowRelaxation, Case6LargeSmallLargeAroundACornerStaysAWindow) {
  std::array<IntBox, 3> cells{IntBox{{0, 0, 0}, {4, 4, 1}}, IntBox{{4, 2, 0}, {6, 4, 1}}, IntBox{{4, 4, 0}, {8, 8, 1}}};
  std::array<Relaxation, 2> decisions{};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kBackward);
  EXPECT_EQ(decisions[1], Relaxation::kNone);
  EXPECT_EQ(cells[1], (IntBox{{0, 2, 0}, {6, 4, 1}}));
}

TEST(WindowRelaxation, Case6StraightOnIsExtrudedAtBothEnds) {
  std::array<IntBox, 3> cells{IntBox{{0, 0, 0}, {4, 4, 1}}, IntBox{{4, 2, 0}, {6, 4, 1}}, IntBox{{6, 0, 0}, {9, 5, 1}}};
  std::array<Relaxation, 2> decisions{};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kBackward);
  EXPECT_EQ(decisions[1], Relaxation::kForward);
  EXPECT_EQ(cells[1], (IntBox{{0, 2, 0}, {9, 4, 1}}));
}

TEST(WindowRelaxation, Case6TurningBackThroughTheSameFaceStaysAWindow) {
  // Into the sliver and out again on the face it was entered by: no machine may extrude it twice through one face.
  std::array<IntBox, 3> cells{IntBox{{0, 0, 0}, {4, 4, 1}}, IntBox{{4, 0, 0}, {5, 4, 1}}, IntBox{{0, 0, 0}, {4, 4, 1}}};
  std::array<Relaxation, 2> decisions{};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kForward);
  EXPECT_EQ(decisions[1], Relaxation::kForward);
  cells = {IntBox{{0, 0, 0}, {4, 4, 1}}, IntBox{{4, 1, 0}, {5, 4, 1}}, IntBox{{0, 0, 0}, {4, 4, 1}}};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kBackward);
  EXPECT_EQ(decisions[1], Relaxation::kNone);
  EXPECT_EQ(cells[1], (IntBox{{0, 1, 0}, {5, 4, 1}}));
}

TEST(WindowRelaxation, ContainmentOfFacesDecidesNotVolume) {
  // The second cell has the larger volume, but its face does not cover the first one's.
  std::array<IntBox, 2> crossed{IntBox{{0, 0, 0}, {1, 4, 1}}, IntBox{{1, 0, 0}, {9, 2, 2}}};
  std::array<Relaxation, 1> decision{Relaxation::kForward};
  relax_windows(crossed, decision);
  EXPECT_EQ(decision[0], Relaxation::kNone);
  EXPECT_EQ(crossed[0], (IntBox{{0, 0, 0}, {1, 4, 1}}));
  EXPECT_EQ(crossed[1], (IntBox{{1, 0, 0}, {9, 2, 2}}));
  // The first cell has the larger volume and the smaller face.
  std::array<IntBox, 2> lance{IntBox{{0, 0, 0}, {9, 1, 1}}, IntBox{{9, 0, 0}, {10, 2, 2}}};
  relax_windows(lance, decision);
  EXPECT_EQ(decision[0], Relaxation::kForward);
  EXPECT_EQ(lance[0], (IntBox{{0, 0, 0}, {10, 1, 1}}));
}

TEST(WindowRelaxation, EqualFacesGoForward) {
  std::array<IntBox, 3> cells{IntBox{{0, 0, 0}, {2, 2, 2}}, IntBox{{0, 0, 2}, {2, 2, 4}}, IntBox{{0, 2, 2}, {2, 4, 4}}};
  std::array<Relaxation, 2> decisions{};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kForward);
  EXPECT_EQ(decisions[1], Relaxation::kForward);
  EXPECT_EQ(cells[0], (IntBox{{0, 0, 0}, {2, 2, 4}}));
  EXPECT_EQ(cells[1], (IntBox{{0, 0, 2}, {2, 4, 4}}));
}

TEST(WindowRelaxation, TheSameChainDownTheAxisGivesTheMirrorImage) {
  std::array<IntBox, 2> cells{IntBox{{4, 0, 0}, {8, 4, 4}}, IntBox{{2, 2, 2}, {4, 4, 4}}};
  std::array<Relaxation, 1> decision{};
  relax_windows(cells, decision);
  EXPECT_EQ(decision[0], Relaxation::kBackward);
  EXPECT_EQ(cells[1], (IntBox{{2, 2, 2}, {8, 4, 4}}));
}

TEST(WindowRelaxation, BoxesThatShareNoWindowAreLeftAlone) {
  std::array<IntBox, 3> cells{IntBox{{0, 0, 0}, {2, 2, 2}}, IntBox{{2, 2, 0}, {4, 4, 2}}, IntBox{{3, 3, 0}, {6, 6, 2}}};
  const std::array<IntBox, 3> before = cells;
  std::array<Relaxation, 2> decisions{Relaxation::kForward, Relaxation::kForward};
  relax_windows(cells, decisions);
  EXPECT_EQ(decisions[0], Relaxation::kNone);
  EXPECT_EQ(decisions[1], Relaxation::kNone);
  for (std::size_t i = 0; i < cells.size(); ++i) EXPECT_EQ(cells[i], before[i]);
}

TEST(WindowRelaxation, OneCellOrNoneAndNoDecisionsAreFine) {
  relax_windows({}, {});
  std::array<IntBox, 1> one{IntBox{{0, 0, 0}, {2, 2, 2}}};
  relax_windows(one, {});
  EXPECT_EQ(one[0], (IntBox{{0, 0, 0}, {2, 2, 2}}));
  std::array<IntBox, 2> two{IntBox{{0, 0, 0}, {1, 1, 1}}, IntBox{{1, 0, 0}, {3, 2, 2}}};
  relax_windows(two, {});
  EXPECT_EQ(two[0], (IntBox{{0, 0, 0}, {3, 1, 1}}));
}

}  // namespace
