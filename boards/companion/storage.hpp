#pragma once
#include <array>
#include <cstddef>
#include <span>

#include "swiftlet/blocked_space.hpp"
#include "swiftlet/storage.hpp"
#include "swiftlet/trajectory_store.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::companion {

inline constexpr std::size_t kMostBlockedBoxes = 16;
inline constexpr std::size_t kMostCutCells = 256;
inline constexpr std::size_t kMostGoals = 16;

/// Memory of a Companion, without that of the planner; CompanionStorage owns it.
struct Memory {
  StoreSpans trajectories;
  std::array<std::span<Box>, 2> boxes;  ///< of the plans in them
  std::array<BlockedSpans, 2> blocked;  ///< as the flight sees it, and as the plan under way does
};

/// All memory of one companion for plans of up to kCapacity.segments, trivially destructible. Make it static.
template <Capacity kCapacity>
class CompanionStorage {
 public:
  Memory memory() {
    return {trajectories_.spans(), {boxes_[0], boxes_[1]}, {blocked_[0].spans(), blocked_[1].spans()}};
  }

 private:
  TrajectorySlots<kCapacity.segments> trajectories_;
  std::array<std::array<Box, kCapacity.segments>, 2> boxes_;
  std::array<BlockedStorage<kMostBlockedBoxes, kMostCutCells>, 2> blocked_;
};

}  // namespace swiftlet::companion
