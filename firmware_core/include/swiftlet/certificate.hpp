#pragma once
#include <array>
#include <optional>
#include <span>

#include "swiftlet/flight_limits.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// What a trajectory was asked to respect. Infinity stands for a limit that was not requested.
struct CertificateRequest {
  std::span<const Box> boxes;  ///< one a segment [m]
  std::span<const Box> gates;  ///< one a junction [m]
  State start;
  State goal;
  Vector3 v_max;                                  ///< [m/s] per axis
  Vector3 a_max;                                  ///< [m/s^2] per axis
  Real speed_max;                                 ///< [m/s] Euclidean
  Real acceleration_norm_max;                     ///< [m/s^2] Euclidean
  Vector3 j_max = Vector3::Constant(kUnlimited);  ///< [m/s^3] per axis
  Real jerk_norm_max = kUnlimited;                ///< [m/s^3] Euclidean
  std::optional<Vehicle> vehicle = {};
};

/// The limits of a request as a certificate wants them: per axis or of the norm, and the vehicle's. Boxes, gates and
/// states are left to the caller.
CertificateRequest certificate_request(const FlightLimits& limits);

/// Proven bounds of a finished trajectory (design: section 5, "Certificate"). Every number is rounded outward.
struct Certificate {
  Real tolerance = 0;                          ///< [of the bound's unit] by which a bound may be exceeded
  Real box_margin = 0;                         ///< [m] least distance inside the faces; a lower bound, negative outside
  Vector3 max_speed = Vector3::Zero();         ///< [m/s] upper bounds per axis
  Real max_speed_norm = 0;                     ///< [m/s]
  Vector3 max_acceleration = Vector3::Zero();  ///< [m/s^2]
  Real max_acceleration_norm = 0;              ///< [m/s^2]
  Vector3 max_jerk = Vector3::Zero();          ///< [m/s^3] upper bounds per axis
  Real max_jerk_norm = 0;                      ///< [m/s^3]
  Real min_thrust = 0;                         ///< [N] m |a + g e_z|, lower bound; 0 without a vehicle
  Real max_thrust = 0;                         ///< [N] upper bound
  Real max_rate = 0;                           ///< [rad/s] about body x and y, at most |jerk| m / thrust; upper bound
  std::array<Real, 3> max_jump{};              ///< [m, m/s, m/s^2] largest jump of p, v, a at a junction
  std::array<Real, 3> max_end_error{};         ///< [m, m/s, m/s^2] end states against the request
  bool pass = false;
};

/// Bounds of `segments` by Bernstein hulls with subdivision and counted rounding errors; shares no code with the
/// solver. Non-finite coefficients never pass. Cost O(M).
Certificate certify(std::span<const Segment> segments, const CertificateRequest& request);

}  // namespace swiftlet
