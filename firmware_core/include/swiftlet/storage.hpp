#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "swiftlet/planner.hpp"

namespace swiftlet {

/// What a board affords; stated once in boards/<board>/board_config.hpp.
struct Capacity {
  std::size_t segments;      ///< boxes of a corridor
  std::size_t search_nodes;  ///< windows that one search may reach
};

/// Where a board keeps a map and a planner; stated beside its Capacity, the whole of both budgets.
struct BoardMemory {
  std::uint64_t map_bytes;      ///< of the region that holds the map blob
  std::uint64_t planner_bytes;  ///< of data memory, for PlannerStorage
};

/// Rows active at once on one axis: every junction against its gate, and a few extrema. Measured (`qp_bench --limits`
/// of tests/bench/qp): 16 at the optimum of 10 segments, 52 of 40, 83 of 80, 281 of 320, the three axes together.
constexpr std::size_t active_rows(std::size_t segments) { return segments + 16; }

/// Memory of the trajectory stage for up to `kSegments` segments, trivially destructible.
template <std::size_t kSegments>
class TrajectoryStorage {
 public:
  TrajectorySpans spans() {
    Pivoting& p = solver_.pivoting;
    Dual& d = solver_.dual;
    return {{p.hold, p.lo, p.hi, p.excess, p.pull, p.knots, p.spans, p.rows, p.knot_states, p.coupling, p.carried_rows},
            {d.factor, d.optimum, d.solution, d.work, d.rows, d.multipliers, d.target, d.direction, d.gram_factor},
            states_,
            scales_,
            violations_,
            labels_};
  }

 private:
  static constexpr std::size_t kActive = active_rows(kSegments);

  struct Pivoting {
    std::array<Hold, kSegments> hold;
    std::array<Real, kSegments> lo;
    std::array<Real, kSegments> hi;
    std::array<Real, kSegments> excess;
    std::array<Real, kSegments> pull;
    std::array<Knot, kSegments> knots;
    std::array<KnotSpan, kSegments> spans;
    std::array<KnotRow, kActive> rows;
    std::array<Real, kBlockSize * kSegments> knot_states;
    std::array<KnotCoupling, kSegments> coupling;
    std::array<CarriedRows, 2> carried_rows;
  };
  struct Dual {
    std::array<FactorBlock, kSegments> factor;
    std::array<Real, kBlockSize * kSegments> optimum;
    std::array<Real, kBlockSize * kSegments> solution;
    std::array<Real, kBlockSize * kSegments> work;
    std::array<QpRow, kActive> rows;
    std::array<Real, kActive> multipliers;
    std::array<Real, kActive> target;
    std::array<Real, kActive> direction;
    std::array<Real, kActive*(kActive + 1) / 2> gram_factor;
  };
  /// One after the other, never both: each writes what it reads.
  union Solver {
    Solver() : dual{} {}
    Pivoting pivoting;
    Dual dual;
  };

  Solver solver_;
  std::array<Real, kBlockSize * kSegments> states_;
  std::array<Real, kSegments> scales_;
  std::array<Violation, kSegments> violations_;
  std::array<QpLabel, kActive> labels_;
};

/// Memory of the refinement of times.
template <std::size_t kSegments>
class RefinementStorage {
 public:
  RefinementSpans spans() { return {trial_, gradient_, overshoots_, {{labels_[0], labels_[1], labels_[2]}, {}}}; }

 private:
  std::array<Real, kSegments> trial_;
  std::array<Real, kSegments> gradient_;
  std::array<std::uint8_t, kSegments> overshoots_;
  std::array<std::array<QpLabel, active_rows(kSegments)>, 3> labels_;
};

/// Memory of a TrajectoryPlanner.
template <std::size_t kSegments>
class TrajectoryPlannerStorage {
 public:
  TrajectoryPlannerSpans spans() {
    return {stop_points_, profile_, durations_, stop_durations_, segments_, trajectory_.spans(), refinement_.spans()};
  }

 private:
  std::array<Vector3, kSegments + 1> stop_points_;
  std::array<Real, kSegments> profile_;
  std::array<Real, kSegments> durations_;
  std::array<Real, kSegments> stop_durations_;
  std::array<Segment, kSegments> segments_;
  TrajectoryStorage<kSegments> trajectory_;
  RefinementStorage<kSegments> refinement_;
};

/// All memory of one planner. Make it static: it is large, and its size is known at compile time.
template <Capacity kCapacity>
class PlannerStorage {
 public:
  PlannerSpans spans() {
    return {{nodes_, open_, hash_}, cell_path_, int_boxes_, boxes_, gates_, points_, taut_nodes_, trajectory_.spans()};
  }

 private:
  // A shortcut corridor holds far fewer boxes than the cells it was made from.
  static constexpr std::size_t kPathCells = 16 * kCapacity.segments;

  std::array<SearchNode, kCapacity.search_nodes> nodes_;
  std::array<OpenEntry, kCapacity.search_nodes> open_;
  std::array<std::uint32_t, std::bit_ceil(2 * kCapacity.search_nodes)> hash_;
  std::array<CellIndex, kPathCells> cell_path_;
  std::array<IntBox, kCapacity.segments> int_boxes_;
  std::array<Box, kCapacity.segments> boxes_;
  std::array<Box, kCapacity.segments> gates_;
  std::array<Vector3, kCapacity.segments + 1> points_;
  std::array<TautNode, kCapacity.segments + 1> taut_nodes_;
  TrajectoryPlannerStorage<kCapacity.segments> trajectory_;
};

}  // namespace swiftlet
