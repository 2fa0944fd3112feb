#include "fly/flight_planner.hpp"

#include <chrono>
#include <utility>

namespace swiftlet::tools {
namespace {

using Clock = std::chrono::steady_clock;

double microseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

template <typename T>
std::vector<T> copy(std::span<const T> items) {
  return {items.begin(), items.end()};
}

}  // namespace

void FlightPlanner::start(const companion::PlanJob& job) {
  job_ = job;
  asked_ = false;
  if (kind_ == Kind::kInline) return compute(job_);
  computation_ = std::async(std::launch::async, [this] { compute(job_); });
}

bool FlightPlanner::done() {
  if (kind_ == Kind::kInline) {
    if (!std::exchange(asked_, true)) return false;
  } else if (computation_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    return false;
  }
  keep();
  return true;
}

void FlightPlanner::compute(const companion::PlanJob& job) {
  const Clock::time_point begin = Clock::now();
  const bool found = planner_.find_corridor(job.map, job.request) == Status::kOk;
  search_us_ = microseconds_since(begin);
  if (found) (void)planner_.fit_trajectory(job.request);
  trajectory_us_ = found ? microseconds_since(begin) - search_us_ : 0;
}

void FlightPlanner::keep() {
  FlownPlan& kept = plans_.emplace_back();
  kept.request = job_.request;
  kept.plan = planner_.result();
  kept.boxes = copy(kept.plan.boxes);
  kept.gates = copy(kept.plan.gates);
  kept.segments = copy(kept.plan.segments);
  kept.plan.int_boxes = {};
  kept.plan.boxes = kept.boxes;
  kept.plan.gates = kept.gates;
  kept.plan.segments = kept.segments;
  kept.search_us = search_us_;
  kept.trajectory_us = trajectory_us_;
  kept.total_us = search_us_ + trajectory_us_;
  kept.map_crc = job_.map.header().crc32;
}

}  // namespace swiftlet::tools
