#include "swiftlet/braking.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

constexpr std::size_t kPhases = 3;
// Ramps are tried from the gentlest, a share of the time that braking takes at full level; shares fall by a tenth.
constexpr int kRamps = 44;  // 0.9^43 = 0.0108
constexpr Real kRampFactor = Real(0.9);
// Levels tried, as shares of the acceleration limit: lower ones serve a start that brakes already.
constexpr std::array<Real, 6> kLevels{1, Real(0.7), Real(0.5), Real(0.3), Real(0.15), Real(0.05)};

/// One axis, mirrored so that it moves forward: v >= 0, and a >= 0 where v = 0.
struct Motion {
  Real v;
  Real a;
  Real v_max;
  Real a_max;
  Real j_max;
};

/// Acceleration over three phases: from `motion.a` to -level, along -level, to zero.
struct Profile {
  std::array<Real, kPhases> time{};
  Real level = 0;
  Real distance = 0;
  bool valid = false;
};

Profile braking_profile(const Motion& motion, Real level, Real ramp) {
  Profile profile;
  profile.level = level;
  const Real change = level + motion.a;
  if (change < 0) return profile;  // brakes harder than that already
  const Real h1 = ramp * change / level;
  const Real v1 = motion.v + (motion.a - level) * h1 / 2;
  const Real t2 = (v1 - level * ramp / 2) / level;
  const Real peak = motion.a > 0 ? motion.v + motion.a * motion.a * h1 / (2 * change) : motion.v;
  if (!(t2 >= 0) || peak > motion.v_max || level > motion.j_max * ramp) return profile;
  profile.time = {h1, t2, ramp};
  profile.distance = motion.v * h1 + motion.a * h1 * h1 / 2 - change * h1 * h1 / 6 + v1 * t2 - level * t2 * t2 / 2 +
                     level * ramp * ramp / 6;
  profile.valid = true;
  return profile;
}

/// The gentlest profile that fits into `room`; otherwise an invalid one with the shortest distance found.
Profile gentlest(const Motion& motion, Real room) {
  Profile shortest;
  shortest.distance = kUnlimited;
  const Real stop = motion.v / motion.a_max + motion.a / motion.a_max * motion.a / motion.a_max;
  Real ramp = std::max({stop, motion.a_max / motion.j_max, Real(1e-3)});
  for (int i = 0; i < kRamps; ++i, ramp *= kRampFactor) {
    for (const Real share : kLevels) {
      const Profile profile = braking_profile(motion, share * motion.a_max, ramp);
      if (!profile.valid) continue;
      if (profile.distance <= room) return profile;
      shortest.distance = std::min(shortest.distance, profile.distance);
    }
  }
  return shortest;
}

/// A braking axis in its own direction.
struct AxisBrake {
  Real p = 0;
  Real v = 0;
  Real a = 0;
  std::array<Real, kPhases> end{};   // [s] when each phase ends
  std::array<Real, kPhases> jerk{};  // [m/s^3] in each phase
};

AxisBrake brake_axis(Real p, Real v, Real a, Real direction, const Profile& profile) {
  AxisBrake brake{p, v, a, {}, {}};
  Real t = 0;
  for (std::size_t i = 0; i < kPhases; ++i) brake.end[i] = t += profile.time[i];
  const std::array<Real, kPhases> change{-profile.level - direction * a, 0, profile.level};
  for (std::size_t i = 0; i < kPhases; ++i) {
    brake.jerk[i] = profile.time[i] > 0 ? direction * change[i] / profile.time[i] : Real(0);
  }
  return brake;
}

/// Coefficients of the piece that starts at `from` [s] and lasts `T`, where it lies in one phase.
std::array<Real, kQuinticTerms> piece_of(const AxisBrake& brake, Real from, Real T) {
  Real p = brake.p;
  Real v = brake.v;
  Real a = brake.a;
  Real begin = 0;
  for (std::size_t i = 0; i < kPhases; ++i) {
    const Real t = std::min(brake.end[i], from) - begin;
    if (from + T / 2 < brake.end[i]) {
      const Real j = brake.jerk[i];
      return {p + t * (v + t * (a / 2 + t * j / 6)), v + t * (a + t * j / 2), (a + t * j) / 2, j / 6, 0, 0};
    }
    const Real j = brake.jerk[i];
    p += t * (v + t * (a / 2 + t * j / 6));
    v += t * (a + t * j / 2);
    a += t * j;
    begin = brake.end[i];
  }
  return {p, 0, 0, 0, 0, 0};  // at rest, up to rounding
}

/// The ends of all phases, ascending, without repetition; returns their number.
std::size_t merge_ends(const std::array<AxisBrake, 3>& axes, std::array<Real, kMostBrakePieces>& ends) {
  std::size_t count = 0;
  for (const AxisBrake& axis : axes) {
    for (const Real end : axis.end) {
      if (end > 0) ends[count++] = end;
    }
  }
  std::sort(ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(count));
  const Real* last = std::unique(ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(count));
  return static_cast<std::size_t>(last - ends.begin());
}

}  // namespace

Braking brake_within(const Box& box, const State& start, const Vector3& v_max, const Vector3& a_max, Real j_max) {
  Braking braking;
  std::array<AxisBrake, 3> axes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    const Real p = start.position[row];
    const Real v = start.velocity[row];
    const Real a = start.acceleration[row];
    axes[axis].p = p;
    if (v == 0 && a == 0) continue;
    const Real direction = v > 0 || (v == 0 && a > 0) ? Real(1) : Real(-1);
    const Real room = direction > 0 ? box.hi[row] - p : p - box.lo[row];
    const Profile profile = gentlest({direction * v, direction * a, v_max[row], a_max[row], j_max}, room);
    if (profile.valid) {
      axes[axis] = brake_axis(p, v, a, direction, profile);
      continue;
    }
    // Where no profile of this kind exists at all, the braking parabola stands for the shortest.
    const Real needed = profile.distance < kUnlimited ? profile.distance : v * v / (2 * a_max[row]);
    const Real missing = std::max(needed - room, Real(0));
    if (braking.missing > 0 && missing <= braking.missing) continue;
    braking.axis = axis;
    braking.missing = std::max(missing, std::numeric_limits<Real>::min());
  }
  if (braking.missing > 0) return braking;
  std::array<Real, kMostBrakePieces> ends{};
  braking.count = merge_ends(axes, ends);
  Real from = 0;
  for (std::size_t i = 0; i < braking.count; ++i) {
    Segment& piece = braking.pieces[i];
    piece.duration = ends[i] - from;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      piece.coefficients[axis] = piece_of(axes[axis], from, piece.duration);
    }
    from = ends[i];
  }
  return braking;
}

}  // namespace swiftlet
