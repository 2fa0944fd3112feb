#pragma once
#include <deque>
#include <future>
#include <vector>

#include "companion/plan_worker.hpp"

namespace swiftlet::tools {

/// A plan that was made in a flight, with memory of its own.
struct FlownPlan {
  PlanRequest request;
  Plan plan;  ///< its spans lead into the vectors below
  std::vector<Box> boxes;
  std::vector<Box> gates;
  std::vector<Segment> segments;
  double search_us = 0;  ///< monotonic times [us]
  double trajectory_us = 0;
  double total_us = 0;
  std::uint32_t id = 0;       ///< the companion's number for a plan that it committed to; 0: it did not
  double at = 0;              ///< [s] when it was committed
  double latency = 0;         ///< [s] from its trigger to the commitment
  std::uint32_t map_crc = 0;  ///< of the map that it was made in

  FlownPlan() = default;
  FlownPlan(const FlownPlan&) = delete;
  FlownPlan& operator=(const FlownPlan&) = delete;
};

/// Makes the plans of a simulated flight and keeps them all: within `start` and done a step later in lock-step, by a
/// thread in real time.
class FlightPlanner final : public companion::PlanWorker {
 public:
  enum class Kind : std::uint8_t { kInline, kThread };
  FlightPlanner(const PlannerSpans& spans, Kind kind) : planner_(spans), kind_(kind) {}

  void start(const companion::PlanJob& job) override;
  bool done() override;
  [[nodiscard]] const Plan& result() const override { return planner_.result(); }

  /// All that are done, in order.
  [[nodiscard]] const std::deque<FlownPlan>& plans() const { return plans_; }
  [[nodiscard]] std::deque<FlownPlan>& plans() { return plans_; }

 private:
  void compute(const companion::PlanJob& job);
  void keep();

  Planner planner_;
  Kind kind_;
  companion::PlanJob job_;
  std::future<void> computation_;
  bool asked_ = false;
  double search_us_ = 0;
  double trajectory_us_ = 0;
  std::deque<FlownPlan> plans_;
};

}  // namespace swiftlet::tools
