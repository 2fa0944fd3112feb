#include "cli/plan_file.hpp"

#include <algorithm>
#include <string_view>

#include "cli/json_reader.hpp"
#include "cli/vehicle_json.hpp"

namespace swiftlet::tools {
namespace {

constexpr const char* kFormat = "swiftlet-plan/1";
constexpr std::array<Status, 9> kStatuses{
    Status::kOk,        Status::kFallback,       Status::kStartNotFree,     Status::kGoalNotFree,
    Status::kNoPath,    Status::kSearchCapacity, Status::kCorridorCapacity, Status::kInfeasible,
    Status::kBadRequest};

class PlanReader : private JsonReader {
 public:
  using JsonReader::JsonReader;

  StoredPlan read(const Json& json) {
    check_format(json, kFormat);
    plan_.status = word(member(json, "status"), "status");
    if (std::none_of(kStatuses.begin(), kStatuses.end(), [&](Status s) { return plan_.status == describe(s); })) {
      refuse("'" + plan_.status + "' is no status of a plan");
    }
    read_map(member(json, "map"));
    if (plan_.has_trajectory()) {
      read_request(member(json, "request"));
      if (json.contains("snapped")) read_snapped(json["snapped"]);
      read_trajectory(json);
      read_certificate(member(json, "certificate"));
    }
    return std::move(plan_);
  }

 private:
  void read_map(const Json& map) {
    plan_.map_crc32 = word(member(map, "crc32"), "map.crc32");
    plan_.map_resolution = number(member(map, "resolution_m"), "map.resolution_m");
    plan_.map_radius = number(member(map, "radius_m"), "map.radius_m");
  }

  void read_request(const Json& request) {
    plan_.start = state(member(request, "start"), "request.start");
    plan_.goal = state(member(request, "goal"), "request.goal");
    plan_.v_max = number(member(request, "vmax"), "request.vmax");
    plan_.a_max = number(member(request, "amax"), "request.amax");
    const std::string norm = word(member(request, "norm"), "request.norm");
    if (norm != "axis" && norm != "euclidean") refuse("'request.norm' is neither \"axis\" nor \"euclidean\"");
    if (request.contains("jmax") && !request["jmax"].is_null()) plan_.j_max = number(request["jmax"], "request.jmax");
    if (request.contains("vehicle") && !request["vehicle"].is_null()) {
      plan_.vehicle = read_vehicle(*this, request["vehicle"], "request.vehicle");
    }
    plan_.norm = norm == "axis" ? LimitNorm::kAxis : LimitNorm::kEuclidean;
  }

  void read_snapped(const Json& snapped) {
    if (snapped.contains("start")) plan_.snapped_start = snapped_end(snapped["start"], "snapped.start");
    if (snapped.contains("goal")) plan_.snapped_goal = snapped_end(snapped["goal"], "snapped.goal");
  }

  void read_trajectory(const Json& json) {
    plan_.boxes = boxes(json, "corridor");
    plan_.gates = boxes(json, "gates");
    for (const Json& item : list(member(json, "segments"), "segments")) plan_.segments.push_back(segment(item));
    plan_.duration = number(member(json, "duration"), "duration");
    plan_.length = number(member(json, "length"), "length");
    plan_.jerk_cost = vector(member(json, "jerk_cost"), "jerk_cost");
  }

  void read_certificate(const Json& json) {
    const auto value = [&](const std::string& key) { return number(member(json, key), "certificate." + key); };
    Certificate& certificate = plan_.certificate;
    certificate.tolerance = value("tolerance");
    certificate.box_margin = value("box_margin");
    certificate.max_speed = vector(member(json, "max_speed"), "certificate.max_speed");
    certificate.max_speed_norm = value("max_speed_norm");
    certificate.max_acceleration = vector(member(json, "max_acceleration"), "certificate.max_acceleration");
    certificate.max_acceleration_norm = value("max_acceleration_norm");
    plan_.has_jerk = json.contains("max_jerk");
    if (plan_.has_jerk) {
      certificate.max_jerk = vector(json["max_jerk"], "certificate.max_jerk");
      certificate.max_jerk_norm = value("max_jerk_norm");
    }
    if (plan_.vehicle) {
      certificate.min_thrust = value("min_thrust");
      certificate.max_thrust = value("max_thrust");
      certificate.max_rate = value("max_rate");
    }
    certificate.pass = boolean(member(json, "pass"), "certificate.pass");
  }

  Vector3 vector(const Json& json, const std::string& what) {
    const std::vector<double> xyz = numbers(json, what, 3);
    return {xyz[0], xyz[1], xyz[2]};
  }

  State state(const Json& json, const std::string& what) {
    return {vector(member(json, "position"), what + ".position"), vector(member(json, "velocity"), what + ".velocity"),
            vector(member(json, "acceleration"), what + ".acceleration")};
  }

  SnappedEnd snapped_end(const Json& json, const std::string& what) {
    return {vector(member(json, "position"), what + ".position"), number(member(json, "moved"), what + ".moved")};
  }

  std::vector<Box> boxes(const Json& json, const std::string& key) {
    std::vector<Box> boxes;
    for (const Json& item : list(member(json, key), key)) {
      const std::vector<double> c = numbers(item, key + "[" + std::to_string(boxes.size()) + "]", 6);
      boxes.push_back({{c[0], c[1], c[2]}, {c[3], c[4], c[5]}});
    }
    return boxes;
  }

  Segment segment(const Json& json) {
    const std::string what = "segments[" + std::to_string(plan_.segments.size()) + "].";
    Segment segment;
    segment.duration = number(member(json, "duration"), what + "duration");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string key(1, "xyz"[axis]);
      const std::vector<double> c = numbers(member(json, key), what + key, kQuinticTerms);
      std::copy(c.begin(), c.end(), segment.coefficients[axis].begin());
    }
    return segment;
  }

  StoredPlan plan_;
};

}  // namespace

StoredPlan load_plan(const std::string& path) { return PlanReader(path).read(load_json(path, kFormat)); }

}  // namespace swiftlet::tools
