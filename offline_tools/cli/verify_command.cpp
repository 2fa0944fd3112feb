#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/map_file.hpp"
#include "cli/plan_file.hpp"
#include "cli/text.hpp"
#include "swiftlet/certificate.hpp"
#include "swiftlet/trajectory.hpp"

namespace swiftlet::tools {
namespace {

struct VerifyOptions {
  std::string plan;
  std::string map;
};

constexpr std::size_t kMaxFindings = 20;
constexpr std::array<double, 3> kJumps{1e-6, 1e-5, 1e-4};  // [m, m/s, m/s^2] that count as rounding
constexpr std::array<const char*, 3> kUnits{" m", " m/s", " m/s^2"};
constexpr std::array<const char*, 3> kDerivatives{"position", "velocity", "acceleration"};

std::string number_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

std::uint64_t volume(const IntBox& box) {
  std::uint64_t product = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) product *= std::uint64_t{box.hi[axis]} - box.lo[axis];
  return product;
}

bool same(const Box& a, const Box& b) { return a.lo == b.lo && a.hi == b.hi; }

/// Checks a stored plan against its map from scratch: nothing that the plan says of itself is taken for granted.
class PlanCheck {
 public:
  PlanCheck(const StoredPlan& plan, const BoxGraphView& graph) : plan_(plan), graph_(graph) {}

  /// What is wrong, one line each; nothing when every promise is kept.
  std::vector<std::string> run() {
    check_map();
    check_counts();
    if (!findings_.empty()) return std::move(findings_);  // nothing below would mean anything
    check_boxes();
    check_gates();
    check_ends();
    check_joints();
    check_segments();
    proof_ = certify(plan_.segments, request());
    if (!proof_.pass && findings_.empty()) find("the trajectory's certificate does not pass");
    check_claims();
    return std::move(findings_);
  }

  [[nodiscard]] const Certificate& proof() const { return proof_; }

 private:
  void find(const std::string& what) { findings_.push_back(what); }

  void check_map() {
    const BlobHeader& header = graph_.header();
    if (plan_.map_crc32 != crc32_text(graph_)) {
      find("the plan was made on another map: its crc32 is " + plan_.map_crc32 + ", this map's " + crc32_text(graph_));
    } else if (plan_.map_resolution != header.resolution || plan_.map_radius != header.radius) {
      find("the plan names another resolution or radius than its map has");
    }
  }

  void check_counts() {
    const std::size_t count = plan_.segments.size();
    if (count == 0) find("there is no segment");
    if (plan_.boxes.size() != count || plan_.gates.size() + 1 != std::max<std::size_t>(count, 1)) {
      find(std::to_string(count) + " segments do not go with " + std::to_string(plan_.boxes.size()) + " boxes and " +
           std::to_string(plan_.gates.size()) + " gates");
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (!(plan_.segments[i].duration > 0)) find("segment " + std::to_string(i) + ": its duration is not positive");
    }
  }

  /// The integers that a box came from; not those of the box itself when it came from none.
  [[nodiscard]] IntBox nearest_on_grid(const Box& box) const {
    const BlobHeader& header = graph_.header();
    IntBox grid{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto nearest = [&](double face) {
        const double units = (face - header.origin[axis]) / graph_.unit();
        return static_cast<std::uint16_t>(std::lround(std::clamp(units, 0.0, static_cast<double>(header.size[axis]))));
      };
      const auto row = static_cast<Eigen::Index>(axis);
      grid.lo[axis] = nearest(box.lo[row]);
      grid.hi[axis] = nearest(box.hi[row]);
    }
    return grid;
  }

  /// Whether a cell's extent holds the box: extents reach into space that '--drop-slivers' left out of all cells.
  [[nodiscard]] bool lies_in_an_extent(const IntBox& box) const {
    for (std::size_t i = 0; i < graph_.cell_count(); ++i) {
      if (contains(graph_.extent(static_cast<CellIndex>(i)), box)) return true;
    }
    return false;
  }

  /// Each box has the faces of integers of the map, to the last bit, and holds nothing but free space.
  void check_boxes() {
    for (std::size_t i = 0; i < plan_.boxes.size(); ++i) {
      const Box& box = plan_.boxes[i];
      const std::string name = "box " + std::to_string(i);
      const IntBox grid = nearest_on_grid(box);
      if (!same(graph_.to_world(grid), box)) {
        find(name + ": its faces are none of the map's");
      } else if (!(box.lo.array() < box.hi.array()).all()) {
        find(name + ": it has no volume");
      } else if (const std::uint64_t covered = graph_.covered_volume(grid);
                 covered != volume(grid) && !lies_in_an_extent(grid)) {
        const double unit3 = graph_.unit() * graph_.unit() * graph_.unit();
        find(name + ": " + number_text(unit3 * static_cast<double>(volume(grid) - covered)) +
             " m^3 of it are not free");
      }
    }
  }

  void check_gates() {
    for (std::size_t i = 0; i < plan_.gates.size(); ++i) {
      const Box& a = plan_.boxes[i];
      const Box& b = plan_.boxes[i + 1];
      const Box common{a.lo.cwiseMax(b.lo), a.hi.cwiseMin(b.hi)};
      const bool touching = (common.lo.array() <= common.hi.array()).all();
      const std::string name = "gate " + std::to_string(i);
      if (!touching || (common.lo.array() < common.hi.array()).count() < 2) {
        find(name + ": its boxes share no passage");
      } else if (!same(common, plan_.gates[i])) {
        find(name + ": it is not the intersection of its boxes");
      }
      check_passes(i);
    }
  }

  void check_passes(std::size_t gate) {
    const Vector3 p = sample_segment(plan_.segments[gate], plan_.segments[gate].duration).position;
    const Box& box = plan_.gates[gate];
    const double outside = std::max((box.lo - p).maxCoeff(), (p - box.hi).maxCoeff());
    if (!(outside <= kJumps[0])) {
      find("segment " + std::to_string(gate) + ": it ends " + number_text(outside) + " m outside its gate");
    }
  }

  [[nodiscard]] static State planned(State end, const std::optional<SnappedEnd>& snapped) {
    if (snapped) end.position = snapped->position;
    return end;
  }

  void check_ends() {
    check_snap("start", plan_.start, plan_.snapped_start);
    check_snap("goal", plan_.goal, plan_.snapped_goal);
    const Segment& last = plan_.segments.back();
    check_equal("at the start", sample_segment(plan_.segments.front(), 0), planned(plan_.start, plan_.snapped_start));
    check_equal("at the goal", sample_segment(last, last.duration), planned(plan_.goal, plan_.snapped_goal));
  }

  void check_snap(const std::string& end, const State& requested, const std::optional<SnappedEnd>& snapped) {
    if (!snapped) return;
    const double moved = (snapped->position - requested.position).norm();
    if (!(std::abs(moved - snapped->moved) <= kJumps[0])) {
      find("the " + end + " was moved by " + number_text(moved) + " m, not by the " + number_text(snapped->moved) +
           " m that the plan names");
    }
  }

  void check_joints() {
    for (std::size_t i = 0; i + 1 < plan_.segments.size(); ++i) {
      const Sample next = sample_segment(plan_.segments[i + 1], 0);
      check_equal("between segments " + std::to_string(i) + " and " + std::to_string(i + 1),
                  sample_segment(plan_.segments[i], plan_.segments[i].duration),
                  {next.position, next.velocity, next.acceleration});
    }
  }

  void check_equal(const std::string& where, const Sample& flown, const State& expected) {
    const std::array<double, 3> off{(flown.position - expected.position).cwiseAbs().maxCoeff(),
                                    (flown.velocity - expected.velocity).cwiseAbs().maxCoeff(),
                                    (flown.acceleration - expected.acceleration).cwiseAbs().maxCoeff()};
    for (std::size_t d = 0; d < 3; ++d) {
      if (!(off[d] <= kJumps[d])) {
        find(std::string("the ") + kDerivatives[d] + " is off by " + number_text(off[d]) + kUnits[d] + " " + where);
      }
    }
  }

  [[nodiscard]] CertificateRequest request() const {
    CertificateRequest request = certificate_request(plan_.limits());
    request.boxes = plan_.boxes;
    request.gates = plan_.gates;
    request.start = planned(plan_.start, plan_.snapped_start);
    request.goal = planned(plan_.goal, plan_.snapped_goal);
    return request;
  }

  /// Each segment by itself, so that a finding names it.
  void check_segments() {
    const bool axis = plan_.norm == LimitNorm::kAxis;
    for (std::size_t i = 0; i < plan_.segments.size(); ++i) {
      CertificateRequest alone = request();
      alone.boxes = alone.boxes.subspan(i, 1);
      alone.gates = {};
      const Certificate bounds = certify(std::span(plan_.segments).subspan(i, 1), alone);
      const std::string name = "segment " + std::to_string(i) + ": ";
      if (!(bounds.box_margin >= -bounds.tolerance)) {
        find(name + "it leaves its box by " + number_text(-bounds.box_margin) + " m");
      }
      const auto check_limit = [&](const char* what, double reached, double limit, const char* unit) {
        if (reached <= limit + bounds.tolerance) return;
        find(name + what + " of " + number_text(reached) + unit + ", limit " + number_text(limit) + unit);
      };
      check_limit("speed", axis ? bounds.max_speed.maxCoeff() : bounds.max_speed_norm, plan_.v_max, kUnits[1]);
      check_limit("acceleration", axis ? bounds.max_acceleration.maxCoeff() : bounds.max_acceleration_norm, plan_.a_max,
                  kUnits[2]);
      check_limit("jerk", axis ? bounds.max_jerk.maxCoeff() : bounds.max_jerk_norm, plan_.j_max, " m/s^3");
      if (!plan_.vehicle) continue;
      check_limit("thrust", bounds.max_thrust, plan_.vehicle->thrust_max, " N");
      check_limit("body rate", bounds.max_rate, plan_.vehicle->rate_max, " rad/s");
      if (bounds.min_thrust < plan_.vehicle->thrust_min - bounds.tolerance) {
        find(name + "thrust of " + number_text(bounds.min_thrust) + " N, at least " +
             number_text(plan_.vehicle->thrust_min) + " N");
      }
    }
  }

  /// What the plan says of its trajectory is what the polynomials say.
  void check_claims() {
    const auto check = [&](const std::string& what, double claimed, double actual, double tolerance) {
      if (std::abs(claimed - actual) <= tolerance) return;
      find("'" + what + "' is " + number_text(claimed) + ", but the polynomials say " + number_text(actual));
    };
    const double duration = total_duration(plan_.segments);
    const double length = arc_length(plan_.segments);
    check("duration", plan_.duration, duration, 1e-9 * duration);
    check("length", plan_.length, length, 1e-4 * length + kJumps[0]);
    const Certificate& claim = plan_.certificate;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto row = static_cast<Eigen::Index>(axis);
      const std::string index = "[" + std::to_string(axis) + "]";
      const double cost = jerk_cost(plan_.segments, axis);
      check("jerk_cost" + index, plan_.jerk_cost[row], cost, 1e-6 * cost + 1e-12);
      check("certificate.max_speed" + index, claim.max_speed[row], proof_.max_speed[row], proof_.tolerance);
      check("certificate.max_acceleration" + index, claim.max_acceleration[row], proof_.max_acceleration[row],
            proof_.tolerance);
    }
    check("certificate.tolerance", claim.tolerance, proof_.tolerance, 0);
    check("certificate.box_margin", claim.box_margin, proof_.box_margin, proof_.tolerance);
    check("certificate.max_speed_norm", claim.max_speed_norm, proof_.max_speed_norm, proof_.tolerance);
    check("certificate.max_acceleration_norm", claim.max_acceleration_norm, proof_.max_acceleration_norm,
          proof_.tolerance);
    if (plan_.has_jerk) {
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        check("certificate.max_jerk[" + std::to_string(axis) + "]", claim.max_jerk[axis], proof_.max_jerk[axis],
              proof_.tolerance);
      }
      check("certificate.max_jerk_norm", claim.max_jerk_norm, proof_.max_jerk_norm, proof_.tolerance);
    }
    if (plan_.vehicle) {
      check("certificate.min_thrust", claim.min_thrust, proof_.min_thrust, proof_.tolerance);
      check("certificate.max_thrust", claim.max_thrust, proof_.max_thrust, proof_.tolerance);
      check("certificate.max_rate", claim.max_rate, proof_.max_rate, proof_.tolerance);
    }
    if (claim.pass != proof_.pass) {
      find(std::string("'certificate.pass' is ") + (claim.pass ? "true" : "false") + ", but the polynomials say " +
           (proof_.pass ? "true" : "false"));
    }
  }

  const StoredPlan& plan_;
  const BoxGraphView& graph_;
  Certificate proof_;
  std::vector<std::string> findings_;
};

ExitStatus run_verify(const VerifyOptions& options) {
  const StoredPlan plan = load_plan(options.plan);
  const MapFile map = load_map(options.map);
  if (!plan.has_trajectory()) {
    throw Failure{ExitStatus::kNoAnswer,
                  options.plan + ": has no trajectory to verify, its status is '" + plan.status + "'"};
  }
  PlanCheck check(plan, map.graph);
  const std::vector<std::string> findings = check.run();
  for (std::size_t i = 0; i < std::min(findings.size(), kMaxFindings); ++i) print_line(findings[i]);
  if (!findings.empty()) {
    throw Failure{ExitStatus::kNoAnswer,
                  options.plan + ": " + std::to_string(findings.size()) + " defects; plan again with 'swiftlet plan'"};
  }
  print_line(options.plan + " holds: " + std::to_string(plan.boxes.size()) + " free boxes, margin " +
             number_text(check.proof().box_margin) + " m, speed " + to_text(check.proof().max_speed.maxCoeff(), 3) +
             " m/s, acceleration " + to_text(check.proof().max_acceleration.maxCoeff(), 3) +
             " m/s^2 on the fastest axis");
  return ExitStatus::kDone;
}

}  // namespace

void add_verify_command(CLI::App& app, Command& chosen) {
  CLI::App* command = add_subcommand(app, "verify", "Check a stored plan against its map, from scratch");
  const auto options = std::make_shared<VerifyOptions>();
  command->add_option("plan", options->plan, "swiftlet-plan/1 file, from 'swiftlet plan --json'")->required();
  command->add_option("map", options->map, "Map that it was planned on")->required();
  command->callback([options, &chosen] { chosen = [options] { return run_verify(*options); }; });
}

}  // namespace swiftlet::tools
