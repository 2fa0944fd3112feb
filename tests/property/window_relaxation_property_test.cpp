#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "swiftlet/window_relaxation.hpp"
#include "swiftlet_test.hpp"

namespace {

using swiftlet::contains;
using swiftlet::IntBox;
using swiftlet::intersection;
using swiftlet::is_passage;
using swiftlet::Relaxation;

using Cells = std::vector<IntBox>;
constexpr std::uint16_t kSize = 16;

enum class Partition { kOctree, kBoxes };

/// Splits a cube of kSize units at random: into octants as an octree does, or by planes anywhere.
Cells random_partition(Partition kind, std::mt19937& random) {
  Cells open{IntBox{{0, 0, 0}, {kSize, kSize, kSize}}};
  Cells cells;
  while (!open.empty()) {
    const IntBox box = open.back();
    open.pop_back();
    const std::size_t axis = random() % 3;
    const int edge = box.hi[axis] - box.lo[axis];
    const bool whole = edge == kSize;
    if (edge < 2 || (!whole && random() % 3 == 0)) {
      cells.push_back(box);
      continue;
    }
    if (kind == Partition::kBoxes) {
      const auto cut = static_cast<std::uint16_t>(box.lo[axis] + 1 + static_cast<int>(random() % (edge - 1)));
      IntBox low = box;
      IntBox high = box;
      low.hi[axis] = high.lo[axis] = cut;
      open.push_back(low);
      open.push_back(high);
      continue;
    }
    const auto half = static_cast<std::uint16_t>(edge / 2);
    for (unsigned octant = 0; octant < 8; ++octant) {
      IntBox child = box;
      for (std::size_t i = 0; i < 3; ++i) {
        child.lo[i] = static_cast<std::uint16_t>(box.lo[i] + ((octant >> i) & 1U) * half);
        child.hi[i] = static_cast<std::uint16_t>(child.lo[i] + half);
      }
      open.push_back(child);
    }
  }
  return cells;
}

/// A walk through cells that share windows, without revisiting any; up to 12 cells.
Cells random_chain(const Cells& cells, std::mt19937& random) {
  std::vector<std::size_t> chain{random() % cells.size()};
  while (chain.size() < 12) {
    std::vector<std::size_t> ways;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (std::find(chain.begin(), chain.end(), i) != chain.end()) continue;
      if (is_passage(intersection(cells[chain.back()], cells[i]))) ways.push_back(i);
    }
    if (ways.empty()) break;
    chain.push_back(ways[random() % ways.size()]);
  }
  Cells boxes;
  for (const std::size_t i : chain) boxes.push_back(cells[i]);
  return boxes;
}

/// Counts unit cubes, so it knows nothing of faces and windows.
bool lies_inside_union(const IntBox& box, const Cells& cells) {
  for (std::uint16_t x = box.lo[0]; x < box.hi[0]; ++x) {
    for (std::uint16_t y = box.lo[1]; y < box.hi[1]; ++y) {
      for (std::uint16_t z = box.lo[2]; z < box.hi[2]; ++z) {
        const IntBox cube{
            {x, y, z},
            {static_cast<std::uint16_t>(x + 1), static_cast<std::uint16_t>(y + 1), static_cast<std::uint16_t>(z + 1)}};
        if (std::none_of(cells.begin(), cells.end(), [&](const IntBox& cell) { return contains(cell, cube); })) {
          return false;
        }
      }
    }
  }
  return true;
}

bool all_lie_inside_union(const Cells& boxes, const Cells& cells) {
  return std::all_of(boxes.begin(), boxes.end(), [&](const IntBox& box) { return lies_inside_union(box, cells); });
}

/// The negative control: every window relaxed towards the larger cell, whatever happened to the window before.
void relax_every_window(Cells& boxes) {
  const Cells cells = boxes;
  const auto volume = [](const IntBox& box) {
    return (box.hi[0] - box.lo[0]) * (box.hi[1] - box.lo[1]) * (box.hi[2] - box.lo[2]);
  };
  for (std::size_t i = 0; i + 1 < cells.size(); ++i) {
    const bool forward = volume(cells[i]) <= volume(cells[i + 1]);
    IntBox& grown = forward ? boxes[i] : boxes[i + 1];
    const IntBox& over = forward ? cells[i + 1] : cells[i];
    const IntBox window = intersection(cells[i], cells[i + 1]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (window.lo[axis] != window.hi[axis]) continue;
      grown.lo[axis] = std::min(grown.lo[axis], over.lo[axis]);
      grown.hi[axis] = std::max(grown.hi[axis], over.hi[axis]);
    }
  }
}

void check_relaxed_chains(Partition kind) {
  int relaxed_windows = 0;
  int unsound_controls = 0;
  for (int run = 0; run < swiftlet::test::kPropertyRuns; ++run) {
    SCOPED_TRACE("seed " + std::to_string(run));
    std::mt19937 random(static_cast<unsigned>(run));
    const Cells cells = random_chain(random_partition(kind, random), random);
    Cells boxes = cells;
    std::vector<Relaxation> decisions(cells.size() - 1);
    swiftlet::relax_windows(boxes, decisions);

    ASSERT_TRUE(all_lie_inside_union(boxes, cells));
    for (std::size_t i = 0; i + 1 < cells.size(); ++i) {
      const IntBox gate = intersection(boxes[i], boxes[i + 1]);
      ASSERT_TRUE(is_passage(gate));
      ASSERT_TRUE(contains(gate, intersection(cells[i], cells[i + 1]))) << "the window belongs to the gate";
      const bool has_volume = gate.lo[0] < gate.hi[0] && gate.lo[1] < gate.hi[1] && gate.lo[2] < gate.hi[2];
      if (decisions[i] != Relaxation::kNone) {
        ASSERT_TRUE(has_volume);
      }
      relaxed_windows += decisions[i] != Relaxation::kNone ? 1 : 0;
      // Sec. IV-E: of two successive windows of octree cells at least one becomes a volume.
      if (kind == Partition::kOctree && i > 0 && decisions[i] == Relaxation::kNone) {
        ASSERT_NE(decisions[i - 1], Relaxation::kNone);
      }
    }

    Cells control = cells;
    relax_every_window(control);
    unsound_controls += all_lie_inside_union(control, cells) ? 0 : 1;
  }
  EXPECT_GT(relaxed_windows, 0);
  EXPECT_GT(unsound_controls, 0) << "without the state machine the property must fail";
}

TEST(WindowRelaxationProperty, ChainsOfOctreeCellsStayInsideTheirUnion) { check_relaxed_chains(Partition::kOctree); }

TEST(WindowRelaxationProperty, ChainsOfMergedCellsStayInsideTheirUnion) { check_relaxed_chains(Partition::kBoxes); }

}  // namespace
