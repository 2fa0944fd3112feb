#include "cli/plan_document.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "cli/vehicle_json.hpp"
#include "swiftlet/trajectory.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kCsvRate = 100;  // [Hz]

Json to_json(const Vector3& v) { return Json::array({v[0], v[1], v[2]}); }

Json to_json(const State& state) {
  return {{"position", to_json(state.position)},
          {"velocity", to_json(state.velocity)},
          {"acceleration", to_json(state.acceleration)}};
}

Json to_json(std::span<const Box> boxes) {
  Json list = Json::array();
  for (const Box& box : boxes) {
    list.push_back(Json::array({box.lo[0], box.lo[1], box.lo[2], box.hi[0], box.hi[1], box.hi[2]}));
  }
  return list;
}

Json to_json(std::span<const Segment> segments) {
  Json list = Json::array();
  for (const Segment& segment : segments) {
    list.push_back({{"duration", segment.duration},
                    {"x", segment.coefficients[0]},
                    {"y", segment.coefficients[1]},
                    {"z", segment.coefficients[2]}});
  }
  return list;
}

Json or_null(bool exists, double value) { return exists ? Json(value) : Json(nullptr); }

Json to_json(const Certificate& certificate, bool has_vehicle) {
  return {{"tolerance", certificate.tolerance},
          {"box_margin", certificate.box_margin},
          {"max_speed", to_json(certificate.max_speed)},
          {"max_speed_norm", certificate.max_speed_norm},
          {"max_acceleration", to_json(certificate.max_acceleration)},
          {"max_acceleration_norm", certificate.max_acceleration_norm},
          {"max_jerk", to_json(certificate.max_jerk)},
          {"max_jerk_norm", certificate.max_jerk_norm},
          {"min_thrust", or_null(has_vehicle, certificate.min_thrust)},
          {"max_thrust", or_null(has_vehicle, certificate.max_thrust)},
          {"max_rate", or_null(has_vehicle, certificate.max_rate)},
          {"pass", certificate.pass}};
}

Json to_json(const Margins& margins) {
  return {{"position", margins.position}, {"velocity", margins.velocity}, {"acceleration", margins.acceleration}};
}

Json to_json(const Blocking& blocking) {
  static constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  static constexpr std::array<const char*, 3> kBounds{"position", "velocity", "acceleration"};
  Json json{{"box", blocking.box},
            {"axis", kAxes[blocking.axis]},
            {"bound", kBounds[static_cast<std::size_t>(blocking.bound)]},
            {"missing", blocking.missing},
            {"stretch", nullptr}};
  if (blocking.stretch > 0) json["stretch"] = blocking.stretch;
  return json;
}

const char* to_word(FallbackReason reason) {
  switch (reason) {
    case FallbackReason::kIterations:
      return "iterations";
    case FallbackReason::kDeadline:
      return "deadline";
    case FallbackReason::kNumerics:
      return "numerics";
    case FallbackReason::kNone:
    case FallbackReason::kStopAtGates:
      break;
  }
  return "stop_at_gates";
}

/// Everything that the polynomials themselves say.
void put_trajectory(Json& json, std::span<const Segment> segments) {
  json["segments"] = to_json(segments);
  json["duration"] = total_duration(segments);
  json["length"] = arc_length(segments);
  json["jerk_cost"] = Json::array({jerk_cost(segments, 0), jerk_cost(segments, 1), jerk_cost(segments, 2)});
}

void put_qp(Json& json, const Vector3& v_max, const Vector3& a_max, const Margins& margins) {
  json["qp"] = {{"vmax", to_json(v_max)}, {"amax", to_json(a_max)}, {"margins", to_json(margins)}};
}

void put_outcome(Json& json, Status status, const TrajectoryReport& report) {
  if (status == Status::kFallback) json["fallback_reason"] = to_word(report.fallback_reason);
  if (status == Status::kInfeasible) json["blocking"] = to_json(report.blocking);
}

void put_solver_stats(Json& stats, const TrajectoryReport& report) {
  stats["qp_iterations"] = report.qp_iterations;
  stats["constraints_added"] = report.constraints_added;
  stats["active"] = report.active;
  stats["work"] = report.work;
  stats["time_scale"] = report.time_scale;
}

void put_snap(Json& json, const char* end, const State& requested, const State& planned) {
  const double moved = (planned.position - requested.position).norm();
  if (moved > 0) json["snapped"][end] = {{"position", to_json(planned.position)}, {"moved", moved}};
}

void append_number(std::string& text, double value) {
  std::array<char, 32> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc()) text.append(digits.data(), end);
}

void append_row(std::string& csv, std::span<const Segment> segments, double t) {
  const Sample sample = sample_trajectory(segments, t);
  append_number(csv, t);
  for (const Vector3& vector : {sample.position, sample.velocity, sample.acceleration, sample.jerk}) {
    for (const double value : vector) {
      csv.push_back(',');
      append_number(csv, value);
    }
  }
  csv.push_back('\n');
}

}  // namespace

Json plan_document(const MapFile& map, const PlanRequest& request, const Plan& plan, const PlanTimes& times,
                   const std::string& reason) {
  Json json{{"format", "swiftlet-plan/1"}, {"status", describe(plan.status)}};
  if (!reason.empty()) json["reason"] = reason;
  const BlobHeader& header = map.graph.header();
  json["map"] = {{"path", map.path},
                 {"crc32", crc32_text(map.graph)},
                 {"resolution_m", header.resolution},
                 {"radius_m", header.radius}};
  json["request"] = {{"start", to_json(request.start)},
                     {"goal", to_json(request.goal)},
                     {"vmax", request.v_max},
                     {"amax", request.a_max},
                     {"jmax", or_null(request.j_max < kUnlimited, request.j_max)},
                     {"vehicle", request.vehicle ? vehicle_json(*request.vehicle) : Json(nullptr)},
                     {"norm", request.norm == LimitNorm::kAxis ? "axis" : "euclidean"},
                     {"corridor", request.corridor == CorridorKind::kExtents ? "extents" : "cells"},
                     {"relax", request.relax}};
  put_snap(json, "start", request.start, plan.start);
  put_snap(json, "goal", request.goal, plan.goal);
  if (!plan.boxes.empty()) {
    json["corridor"] = to_json(plan.boxes);
    json["gates"] = to_json(plan.gates);
  }
  if (!plan.segments.empty()) put_trajectory(json, plan.segments);
  if (times.trajectory) put_qp(json, plan.qp_v_max, plan.qp_a_max, Margins{});
  if (!plan.segments.empty()) json["certificate"] = to_json(plan.certificate, request.vehicle.has_value());
  put_outcome(json, plan.status, plan.trajectory);

  Json& stats = json["stats"];
  stats["search_us"] = times.search;
  if (times.trajectory) stats["trajectory_us"] = *times.trajectory;
  stats["total_us"] = times.total;
  stats["expanded"] = plan.search.expanded;
  if (times.trajectory) put_solver_stats(stats, plan.trajectory);
  return json;
}

Json case_document(const TrajectoryCase& problem, const CaseAnswer& answer) {
  Json json{{"format", "swiftlet-plan/1"}};
  if (problem.name) json["name"] = *problem.name;
  // A case that found no answer has no word in the contract: null keeps its line, and the program reports a defect.
  const bool answered = answer.status != Status::kIterationLimit && answer.status != Status::kNumericalTrouble;
  json["status"] = answered ? Json(describe(answer.status)) : Json(nullptr);
  if (!answer.reason.empty()) json["reason"] = answer.reason;
  json["request"] = {{"start", to_json(problem.start)},
                     {"goal", to_json(problem.goal)},
                     {"vmax", problem.v_max},
                     {"amax", problem.a_max},
                     {"norm", "axis"}};
  json["corridor"] = to_json(problem.boxes);
  json["gates"] = to_json(problem.gates);
  if (!answer.segments.empty()) put_trajectory(json, answer.segments);
  put_qp(json, Vector3::Constant(problem.v_max), Vector3::Constant(problem.a_max), problem.margins);
  if (!answer.segments.empty()) json["certificate"] = to_json(answer.certificate, false);
  put_outcome(json, answer.status, answer.report);
  if (answer.status == Status::kBadRequest) return json;

  Json& stats = json["stats"];
  stats["trajectory_us"] = answer.time_us;
  stats["total_us"] = answer.time_us;
  put_solver_stats(stats, answer.report);
  return json;
}

std::string trajectory_csv(std::span<const Segment> segments) {
  std::string csv = "t,x,y,z,vx,vy,vz,ax,ay,az,jx,jy,jz\n";
  const double duration = total_duration(segments);
  for (std::size_t row = 0; static_cast<double>(row) / kCsvRate < duration; ++row) {
    append_row(csv, segments, static_cast<double>(row) / kCsvRate);
  }
  append_row(csv, segments, duration);
  return csv;
}

}  // namespace swiftlet::tools
