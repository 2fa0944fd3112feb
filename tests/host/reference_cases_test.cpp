// The reference cases of trajectory generation in the core's own precision, straight through generate_trajectory: what
// `solve` answers in double (solve_test), float must answer too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "swiftlet/storage.hpp"

namespace swiftlet {
namespace {

constexpr bool kIsDouble = sizeof(Real) == 8;
// Bounds [m, m/s, m/s^2], and cost summed over the axes against the reference: median and worst.
constexpr Real kExcess = kIsDouble ? Real(1e-6) : Real(1e-3);
constexpr double kMedianCost = kIsDouble ? 1e-6 : 0.01;
constexpr double kWorstCost = kIsDouble ? 1e-5 : 0.05;

TrajectoryStorage<128> storage;

std::filesystem::path cases_file() {
  const char* named = std::getenv("SWIFTLET_SHARED");
  const std::filesystem::path shared =
      named != nullptr ? std::filesystem::path(named) : std::filesystem::path(SWIFTLET_SOURCE_DIR) / "../shared";
  return shared / "cases/cases.jsonl";
}

Vector3 vector_at(const nlohmann::json& numbers, std::size_t first) {
  Vector3 v;
  for (std::size_t k = 0; k < 3; ++k) v[static_cast<Eigen::Index>(k)] = numbers[first + k].get<Real>();
  return v;
}

std::vector<Box> boxes_of(const nlohmann::json& list) {
  std::vector<Box> boxes;
  for (const nlohmann::json& box : list) boxes.push_back({vector_at(box, 0), vector_at(box, 3)});
  return boxes;
}

/// One case with the memory that its problem refers to.
struct Case {
  std::vector<Box> boxes;
  std::vector<Box> gates;
  std::vector<Real> durations;
  TrajectoryProblem problem;

  explicit Case(const nlohmann::json& json)
      : boxes(boxes_of(json["boxes"])), gates(boxes_of(json["gates"])), durations(json["durations"]) {
    problem = {.boxes = boxes,
               .gates = gates,
               .durations = durations,
               .start = {.position = vector_at(json["start"]["position"], 0)},
               .goal = {.position = vector_at(json["goal"]["position"], 0)},
               .v_max = Vector3::Constant(json["vmax"].get<Real>()),
               .a_max = Vector3::Constant(json["amax"].get<Real>())};
  }
};

Real largest_excess(const TrajectoryProblem& problem, const std::vector<Segment>& segments) {
  Real worst = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    for (int k = 0; k <= 200; ++k) {
      const Sample s = sample_segment(segments[i], segments[i].duration * static_cast<Real>(k) / 200);
      worst = std::max(
          {worst, (s.position - problem.boxes[i].hi).maxCoeff(), (problem.boxes[i].lo - s.position).maxCoeff(),
           (s.velocity.cwiseAbs() - problem.v_max).maxCoeff(), (s.acceleration.cwiseAbs() - problem.a_max).maxCoeff()});
    }
  }
  return worst;
}

TEST(ReferenceCases, EveryCaseIsAnsweredWithinItsBoundsAtItsCost) {
  if (!std::filesystem::exists(cases_file())) GTEST_SKIP() << "the reference cases are not there: ../shared/cases";
  std::ifstream file(cases_file());
  std::vector<double> errors;
  std::string line;
  while (std::getline(file, line)) {
    const nlohmann::json json = nlohmann::json::parse(line);
    const std::string name = json["name"];
    const Case reference(json);
    std::vector<Segment> segments(reference.boxes.size());
    TrajectoryReport report;
    const Status status = generate_trajectory(reference.problem, storage.spans(), segments, report);
    const nlohmann::json& expected = json["expected"];
    const bool feasible =
        std::find(expected["status"].begin(), expected["status"].end(), "infeasible") == expected["status"].end();
    // In float a case that is infeasible by less than its tolerance may be answered, within the bounds.
    if (!feasible && (kIsDouble || status != Status::kOk)) {
      EXPECT_EQ(status, Status::kInfeasible) << name;
      continue;
    }
    ASSERT_EQ(status, Status::kOk) << name;
    EXPECT_LE(report.residual, kExcess) << name;
    EXPECT_LE(largest_excess(reference.problem, segments), kExcess) << name;
    if (!feasible) continue;
    double cost = 0;
    double optimum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cost += static_cast<double>(jerk_cost(segments, axis));
      optimum += expected["cost"][axis].get<double>();
    }
    errors.push_back(std::fabs(cost - optimum) / std::max(optimum, 1e-3));
  }
  ASSERT_GE(errors.size(), std::size_t{50});
  std::sort(errors.begin(), errors.end());
  std::printf("cost against the reference: median %.1e, worst %.1e\n", errors[errors.size() / 2], errors.back());
  EXPECT_LE(errors[errors.size() / 2], kMedianCost);
  EXPECT_LE(errors.back(), kWorstCost);
}

}  // namespace
}  // namespace swiftlet
