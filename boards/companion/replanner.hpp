#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "companion/goals.hpp"
#include "companion/plan_worker.hpp"
#include "companion/reach.hpp"
#include "companion/settings.hpp"
#include "companion/storage.hpp"
#include "companion/telemetry.hpp"
#include "swiftlet/blocked_space.hpp"
#include "swiftlet/trajectory_store.hpp"

namespace swiftlet::companion {

/// How a plan ended.
struct PlanEnd {
  Status status = Status::kBadRequest;             ///< the planner's
  OfferResult offer = OfferResult::kNotCertified;  ///< the store's; means something with a certified plan only
  bool committed = false;
  bool hopeless = false;  ///< late although it was given all the time there is
  bool too_far = false;   ///< it leads beyond the margins' reach
  std::uint32_t goal = 0;
  bool from_rest = true;
};

/// The map with what blocks it, and plans in it: begun from the reference's state ahead, and taken over only with a
/// passing certificate, in time, and while they are still what is wanted.
class Replanner {
 public:
  Replanner(const Settings& settings, const BoxGraphView& map, const Memory& memory, PlanWorker& worker);

  /// The map as it is now. Good until the next change.
  [[nodiscard]] BoxGraphView map() const { return seen_.view(); }
  [[nodiscard]] std::uint32_t map_crc() const { return map_.header().crc32; }
  /// Errors as BlockedSpace::add: the obstacle is then not kept out of.
  Status block(std::uint32_t id, const Box& obstacle);
  bool unblock(std::uint32_t id);
  /// Blocked boxes stay; kBufferTooSmall when they do not fit into the new map, which then has fewer.
  Status replace_map(const BoxGraphView& map);
  void shift_clock(TimeUs jump);
  void set_limits(Real v_max, Real a_max);
  [[nodiscard]] const FlightLimits& limits() const { return limits_; }

  /// Whether the rest of what `store` flies meets something blocked.
  [[nodiscard]] bool path_blocked(const TrajectoryStore& store, TimeUs now) const;
  /// Whether the straight way between two points [m] meets something blocked.
  [[nodiscard]] bool way_blocked(const Vector3& from, const Vector3& to) const;

  [[nodiscard]] bool under_way() const { return under_way_; }
  /// Begins a plan to `goal`, wanted since `trigger`, that is taken within `reach` only; false when the reference
  /// cannot be spliced yet.
  bool begin(const Goal& goal, TimeUs trigger, const Reach& reach, TrajectoryStore& store, TimeUs now);
  /// Once a step while one is under way; an answer when it is done. `wanted`: it is still what it was begun for.
  std::optional<PlanEnd> poll(bool wanted, TrajectoryStore& store, TimeUs now);
  [[nodiscard]] std::uint32_t goal_under_way() const { return goal_.id; }

  [[nodiscard]] const CommittedPlan& committed() const { return committed_; }
  [[nodiscard]] std::uint32_t discarded() const { return discarded_; }
  [[nodiscard]] std::uint32_t late() const { return late_; }
  [[nodiscard]] std::uint32_t late_in_row() const { return late_in_row_; }

 private:
  struct Obstacle {
    std::uint32_t id = 0;
    Box box;
  };
  [[nodiscard]] PlanRequest request_for(const Goal& goal, const State& start) const;
  OfferResult offer(const Plan& plan, TrajectoryStore& store, TimeUs now);
  void commit(const Plan& plan, const TrajectoryStore& store, TimeUs now);
  void keep(std::uint32_t id, const Box& obstacle);
  void bring_up_to_date();

  const Settings& settings_;
  PlanWorker& worker_;
  BoxGraphView map_;
  FlightLimits limits_;
  std::array<BlockedSpans, 2> blocked_spans_;
  std::array<std::span<Box>, 2> box_spans_;

  BlockedSpace seen_;      // by the flight, at once
  BlockedSpace searched_;  // by the plan under way, which another thread may be making
  std::array<Obstacle, kMostBlockedBoxes> obstacles_;
  std::size_t obstacle_count_ = 0;
  bool searched_is_old_ = false;

  bool under_way_ = false;
  Goal goal_;
  Reach reach_;
  Splice splice_;
  FlightLimits planned_limits_;
  std::uint32_t planned_map_ = 0;
  TimeUs trigger_ = 0;

  CommittedPlan committed_;
  std::size_t box_slot_ = 0;
  std::uint32_t discarded_ = 0;
  std::uint32_t late_ = 0;
  std::uint32_t late_in_row_ = 0;
};

}  // namespace swiftlet::companion
