#pragma once
#include <optional>
#include <span>
#include <string>

#include "cli/case_file.hpp"
#include "cli/json.hpp"
#include "cli/map_file.hpp"
#include "swiftlet/planner.hpp"

namespace swiftlet::tools {

/// Monotonic times of one plan [us]; contract.md says what `total` spans.
struct PlanTimes {
  double search = 0;
  std::optional<double> trajectory;  ///< absent when no corridor was found
  double total = 0;
};

/// The format swiftlet-plan/1 (contract.md) of a plan on a map. `reason` is the line for people of a plan without an
/// answer, empty otherwise.
Json plan_document(const MapFile& map, const PlanRequest& request, const Plan& plan, const PlanTimes& times,
                   const std::string& reason);

/// What `solve` found for a case.
struct CaseAnswer {
  Status status = Status::kBadRequest;
  std::span<const Segment> segments;  ///< empty without a trajectory
  Certificate certificate;
  TrajectoryReport report;
  std::string reason;  ///< why there is no answer, for people
  double time_us = 0;  ///< monotonic, from the parsed case to the certified trajectory
};

/// The same format for a case of trajectory generation alone.
Json case_document(const TrajectoryCase& problem, const CaseAnswer& answer);

/// `t,x,y,z,vx,...,jz`: a row every 0.01 s from 0, the last exactly at the end.
std::string trajectory_csv(std::span<const Segment> segments);

}  // namespace swiftlet::tools
