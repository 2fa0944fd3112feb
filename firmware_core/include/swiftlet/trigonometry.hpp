#pragma once
#include "swiftlet/types.hpp"

namespace swiftlet {

/// Trigonometry of + - * / and sqrt alone, so that its bits are the same on every board, which those of the C libraries
/// are not. Worked out in double for either kind of Real; errors below 1e-15, of angles beyond a few turns as much more
/// as their own last digit is worth. `angle` [rad] is at most 1e6 in magnitude; NaN gives NaN.
Real sine(Real angle);
Real cosine(Real angle);

/// Angle of the vector (x, y) from the x axis [rad] in [-pi, pi], with the sign of `y`; 0 or pi for the zero vector.
/// The smaller of |x| and |y| is finite.
Real angle_of(Real y, Real x);

}  // namespace swiftlet
