#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "swiftlet/certificate.hpp"
#include "swiftlet/planner.hpp"

namespace swiftlet::tools {

/// An end that `--snap` moved.
struct SnappedEnd {
  Vector3 position;  ///< [m] that was planned from or to
  double moved = 0;  ///< [m]
};

/// What a file of the format swiftlet-plan/1 says of a plan on a map (contract.md), none of it checked yet.
struct StoredPlan {
  std::string status;
  std::string map_crc32;
  double map_resolution = 0;  ///< [m]
  double map_radius = 0;      ///< [m]
  State start;                ///< the request's
  State goal;
  std::optional<SnappedEnd> snapped_start;
  std::optional<SnappedEnd> snapped_goal;
  double v_max = 0;           ///< [m/s]
  double a_max = 0;           ///< [m/s^2]
  double j_max = kUnlimited;  ///< [m/s^3]
  LimitNorm norm = LimitNorm::kAxis;
  std::optional<Vehicle> vehicle;
  // The rest is empty unless the status has a trajectory.
  std::vector<Box> boxes;
  std::vector<Box> gates;
  std::vector<Segment> segments;
  double duration = 0;  ///< [s]
  double length = 0;    ///< [m]
  Vector3 jerk_cost = Vector3::Zero();
  bool has_jerk = false;    ///< whether the certificate speaks of jerk and thrust: those of older plans do not
  Certificate certificate;  ///< without jumps and end errors, which the format leaves out

  [[nodiscard]] FlightLimits limits() const { return {v_max, a_max, j_max, norm, vehicle}; }

  /// Whether the status is one that comes with a trajectory.
  [[nodiscard]] bool has_trajectory() const { return status == "optimal" || status == "fallback"; }
};

/// Throws Failure (kBadFile) naming file and fault for text that is no JSON or has another shape than the format.
StoredPlan load_plan(const std::string& path);

}  // namespace swiftlet::tools
