#pragma once
#include <cstdint>
#include <limits>
#include <optional>

#include "swiftlet/flatness.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

inline constexpr Real kUnlimited = std::numeric_limits<Real>::infinity();

/// Speed [m/s] and acceleration [m/s^2] limits outside this range are no request of a multirotor.
inline constexpr Real kLeastLimit = Real(1e-3);
inline constexpr Real kLargestLimit = Real(1e3);

/// What speed, acceleration and jerk limits bound: each axis, or the length of the vector.
enum class LimitNorm : std::uint8_t { kAxis, kEuclidean };

/// What the thrust and the body rates of a multirotor bound through flatness (Sec. IV-A).
struct Vehicle {
  Real mass = 0;        ///< [kg] > 0
  Real thrust_min = 0;  ///< [N] >= 0, less than the weight
  Real thrust_max = 0;  ///< [N] more than the weight
  Real rate_max = 0;    ///< [rad/s] > 0, about the body's x and y axes
};

/// The limits of a request.
struct FlightLimits {
  Real v_max = 0;           ///< [m/s]
  Real a_max = 0;           ///< [m/s^2]
  Real j_max = kUnlimited;  ///< [m/s^3]
  LimitNorm norm = LimitNorm::kAxis;
  std::optional<Vehicle> vehicle;
};

/// Whether every limit is positive, in range, and the vehicle can hover.
bool is_usable(const FlightLimits& limits);

/// Bounds of one derivative: of each axis, and of the Euclidean norm; infinity for none.
struct DerivativeBound {
  Real axis = kUnlimited;
  Real norm = kUnlimited;
};

/// Bounds of the motion alone that suffice for every limit of a request: those of the norm, and, where a vehicle is
/// given, |a| <= A and |j| <= rate (g - A) with A = min(g - f_min / m, f_max / m - g), made smaller where `a_max`
/// already is (design: section 6).
struct MotionBounds {
  DerivativeBound v;  ///< [m/s]
  DerivativeBound a;  ///< [m/s^2]
  DerivativeBound j;  ///< [m/s^3]

  /// Whether anything but speed and acceleration of each axis is bounded.
  [[nodiscard]] bool exceed_axes() const {
    return v.norm < kUnlimited || a.norm < kUnlimited || j.axis < kUnlimited || j.norm < kUnlimited;
  }
};
MotionBounds motion_bounds(const FlightLimits& limits);

/// The factor on its duration with which a segment would just keep the bounds that the QP does not know, those of norms
/// and of jerk; below 1 where it is slower than it need be. Looked at in 9 points: an estimate, not a proof.
Real slow_down(const Segment& segment, const MotionBounds& bounds);

/// The cube root of x >= 0, by Newton's method: + - * / alone.
Real cube_root(Real x);

}  // namespace swiftlet
