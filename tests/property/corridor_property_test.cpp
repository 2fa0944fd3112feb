#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "swiftlet/corridor.hpp"
#include "swiftlet_test.hpp"

namespace {

using swiftlet::Box;
using swiftlet::kTautGap;
using swiftlet::Real;
using swiftlet::TautNode;
using swiftlet::TautReport;
using swiftlet::Vector3;

struct Chain {
  Vector3 start;
  Vector3 goal;
  std::vector<Box> gates;
};

enum class Kind {
  kOverlaps,  ///< boxes overlap: gates have volume, and the chain wanders back over itself
  kWindows,   ///< boxes touch in a face: gates are thin on one axis
  kSlivers,   ///< voxel-sized boxes, windows that share edges: many points coincide
};

class ChainMaker {
 public:
  explicit ChainMaker(unsigned seed) : random_(seed) {}

  /// Boxes on a lattice of 0.08 m, as a map gives them.
  Chain make(Kind kind, std::size_t boxes) {
    Chain chain;
    Box box{Vector3::Constant(Real(-0.4)), Vector3::Constant(Real(0.4))};
    chain.start = inside(box);
    for (std::size_t i = 1; i < boxes; ++i) {
      const Box next = kind == Kind::kOverlaps  ? overlapping(box)
                       : kind == Kind::kWindows ? touching(box)
                                                : sliver(box, static_cast<Eigen::Index>(i % 3));
      chain.gates.push_back({box.lo.cwiseMax(next.lo), box.hi.cwiseMin(next.hi)});
      box = next;
    }
    chain.goal = inside(box);
    return chain;
  }

 private:
  Real uniform(Real lo, Real hi) { return lo + (hi - lo) * static_cast<Real>(random_() % 4096) / 4096; }
  static Real lattice(Real value) { return Real(0.08) * std::round(value / Real(0.08)); }
  Vector3 inside(const Box& box) {
    return {uniform(box.lo[0], box.hi[0]), uniform(box.lo[1], box.hi[1]), uniform(box.lo[2], box.hi[2])};
  }
  void widen_around(Real centre, Real widest, Box& box, Eigen::Index axis) {
    box.lo[axis] = lattice(centre - uniform(Real(0.05), widest));
    box.hi[axis] = std::max(lattice(centre + uniform(Real(0.05), widest)), box.lo[axis] + Real(0.08));
  }
  Box overlapping(const Box& box) {
    Box next;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      widen_around(uniform(box.lo[axis], box.hi[axis]), Real(1.5), next, axis);
      meet(box, next, axis);
    }
    return next;
  }
  Box touching(const Box& box) {
    Box next;
    const auto thin = static_cast<Eigen::Index>(random_() % 3);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (axis != thin) {
        widen_around(uniform(box.lo[axis], box.hi[axis]), Real(0.8), next, axis);
        meet(box, next, axis);
      } else if (random_() % 4 == 0) {
        next.hi[axis] = box.lo[axis];
        next.lo[axis] = next.hi[axis] - lattice(uniform(Real(0.08), Real(1.2)));
      } else {
        next.lo[axis] = box.hi[axis];
        next.hi[axis] = next.lo[axis] + lattice(uniform(Real(0.08), Real(1.2)));
      }
    }
    return next;
  }
  Box sliver(const Box& box, Eigen::Index thin) {
    Box next = box;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (axis == thin) {
        next.lo[axis] = box.hi[axis];
        next.hi[axis] = next.lo[axis] + Real(0.08);
      } else {
        next.hi[axis] += Real(0.08) * static_cast<Real>(random_() % 2);
        if (next.hi[axis] - box.lo[axis] > Real(0.12)) next.lo[axis] += Real(0.08) * static_cast<Real>(random_() % 2);
      }
    }
    return next;
  }
  static void meet(const Box& box, Box& next, Eigen::Index axis) {
    next.lo[axis] = std::min(next.lo[axis], box.hi[axis]);
    next.hi[axis] = std::max(next.hi[axis], box.lo[axis]);
  }

  std::mt19937 random_;
};

/// Weak duality, written down again in double: |d| >= u.d for |u| <= 1, so the least value of the sum of u_i.d_i over
/// all points of the gates bounds the length of every polyline through them.
double independent_lower_bound(const Chain& chain, const std::vector<TautNode>& nodes) {
  const std::size_t legs = chain.gates.size() + 1;
  std::vector<Eigen::Vector3d> tension;
  for (std::size_t i = 0; i < legs; ++i) {
    Eigen::Vector3d u = nodes[i].tension.cast<double>();
    u /= std::max(1.0, u.norm());
    tension.push_back(u);
  }
  double bound = tension.back().dot(chain.goal.cast<double>()) - tension.front().dot(chain.start.cast<double>());
  for (std::size_t i = 0; i + 1 < legs; ++i) {
    const Eigen::Vector3d pull = tension[i] - tension[i + 1];
    const Eigen::Vector3d at_lo = pull.cwiseProduct(chain.gates[i].lo.cast<double>());
    const Eigen::Vector3d at_hi = pull.cwiseProduct(chain.gates[i].hi.cast<double>());
    bound += at_lo.cwiseMin(at_hi).sum();
  }
  return bound;
}

double length_of(const std::vector<Vector3>& points) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    length += (points[i + 1].cast<double>() - points[i].cast<double>()).norm();
  }
  return length;
}

void check_chains(Kind kind, std::size_t boxes, int runs) {
  std::vector<int> steps;
  for (int run = 0; run < runs; ++run) {
    SCOPED_TRACE("seed " + std::to_string(run) + ", " + std::to_string(boxes) + " boxes");
    const Chain chain = ChainMaker(static_cast<unsigned>(run)).make(kind, boxes);
    std::vector<Vector3> points(boxes + 1);
    std::vector<TautNode> nodes(boxes + 1);
    const TautReport report = swiftlet::pull_taut(chain.start, chain.goal, chain.gates, points, nodes);
    steps.push_back(report.steps);

    ASSERT_EQ(points.front(), chain.start);
    ASSERT_EQ(points.back(), chain.goal);
    for (std::size_t i = 0; i + 1 < boxes; ++i) {
      ASSERT_TRUE((points[i + 1].array() >= chain.gates[i].lo.array()).all());
      ASSERT_TRUE((points[i + 1].array() <= chain.gates[i].hi.array()).all());
    }
    const double length = length_of(points);
    ASSERT_NEAR(report.length, length, 1e-5 * length);
    const double straight = (chain.goal - chain.start).cast<double>().norm();
    const double bound = report.steps == 0 ? straight : independent_lower_bound(chain, nodes);
    ASSERT_NEAR(report.lower_bound, bound, 1e-5 * length);
    ASSERT_LE(length - bound, (static_cast<double>(kTautGap) + 1e-5) * length);
  }
  std::sort(steps.begin(), steps.end());
  ::testing::Test::RecordProperty("median_steps", steps[steps.size() / 2]);
  std::printf("%zu boxes, %d chains: %d Newton steps at the median, %d at most\n", boxes, runs, steps[steps.size() / 2],
              steps.back());
}

constexpr int kRuns = swiftlet::test::kPropertyRuns;

TEST(TautProperty, VolumesArePulledTautToAThousandth) {
  for (const std::size_t boxes : {2, 5, 20, 60}) check_chains(Kind::kOverlaps, boxes, kRuns);
}
TEST(TautProperty, WindowsArePulledTautToAThousandth) {
  for (const std::size_t boxes : {2, 5, 20, 60}) check_chains(Kind::kWindows, boxes, kRuns);
}
TEST(TautProperty, SliversArePulledTautToAThousandth) {
  for (const std::size_t boxes : {2, 5, 20, 60}) check_chains(Kind::kSlivers, boxes, kRuns);
}
TEST(TautProperty, ChainsOfThreeHundredBoxesArePulledTautToAThousandth) {
  for (const Kind kind : {Kind::kOverlaps, Kind::kWindows, Kind::kSlivers}) check_chains(kind, 300, kRuns / 10 + 1);
}

}  // namespace
