#pragma once
#include <string>

#include "cli/json.hpp"
#include "sim/quadrotor.hpp"

namespace swiftlet::tools {

/// The format swiftlet-vehicle/1.
struct VehicleFile {
  VehicleModel model;
  double
      hover_thrust;  ///< MPC_THR_HOVER: what the autopilot believes; the true fraction unless the file says otherwise
};

/// A vehicle file:
///   {"format": "swiftlet-vehicle/1", "mass_kg": n, "thrust_min_n": n, "thrust_max_n": n, "rate_max_rad_s": n,
///    "simulation": {"inertia_kg_m2": [3], "motor_lag_s": n, "arm_m": n, "torque_per_thrust_m": n,
///                   "drag_n_per_mps": n, "angular_drag_nm_per_rad_s": n, "hover_thrust": n}}
/// `simulation` and its members are optional. Throws Failure (kBadFile) naming file and fault: a missing or unknown
/// key, a value out of range, a vehicle that cannot hover.
VehicleFile load_vehicle(const std::string& path);

}  // namespace swiftlet::tools
