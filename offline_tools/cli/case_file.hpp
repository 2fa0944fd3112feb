#pragma once
#include <optional>
#include <string>
#include <vector>

#include "swiftlet/trajectory_generator.hpp"

namespace swiftlet::tools {

/// The format swiftlet-case/1 (contract.md). Limits that were not requested are infinite.
struct TrajectoryCase {
  std::optional<std::string> name;
  std::vector<Box> boxes;
  std::vector<Box> gates;
  std::vector<Real> durations;  ///< [s]
  State start;
  State goal;
  double v_max = 0;  ///< [m/s]
  double a_max = 0;  ///< [m/s^2]
  Margins margins;
  std::string defect;  ///< why no planner could take it (status bad_request); empty when there is nothing to say
};

/// Both throw Failure (kBadFile) naming file, line and fault for text that is no JSON or has another shape than the
/// format: a missing key, a value of another type. Numbers that contradict each other are a `defect`.
TrajectoryCase load_case(const std::string& path);
/// One case a line; empty lines are skipped.
std::vector<TrajectoryCase> load_cases(const std::string& path);

}  // namespace swiftlet::tools
