#include "cli/config_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "cli/json_reader.hpp"

namespace swiftlet::tools {
namespace {

using companion::Settings;

constexpr const char* kFormat = "swiftlet-config/1";

template <typename Enum, std::size_t kCount>
using Words = std::array<std::pair<Enum, const char*>, kCount>;

constexpr Words<SetpointForm, 3> kForms{
    {{SetpointForm::kPosition, "position"}, {SetpointForm::kAttitude, "attitude"}, {SetpointForm::kRates, "rates"}}};
constexpr Words<LimitNorm, 2> kNorms{{{LimitNorm::kAxis, "axis"}, {LimitNorm::kEuclidean, "euclidean"}}};
constexpr Words<YawMode, 3> kYawModes{
    {{YawMode::kFixed, "fixed"}, {YawMode::kAlongPath, "path"}, {YawMode::kTowards, "point"}}};
constexpr Words<CorridorKind, 2> kCorridors{{{CorridorKind::kExtents, "extents"}, {CorridorKind::kCells, "cells"}}};
constexpr Words<SearchMode, 3> kSearches{
    {{SearchMode::kDefault, "default"}, {SearchMode::kLandmarks, "landmarks"}, {SearchMode::kPlain, "plain"}}};

/// Takes what a document says over into settings; what it does not mention stays.
class Reader : private JsonReader {
 public:
  Reader(std::string where, const Json& json) : JsonReader(std::move(where)), json_(&json) {
    check_format(json, kFormat);
    known_.insert("format");
  }

  void number(const char* key, Real& value) {
    if (const Json* json = find(key)) value = finite(*json, key);
  }
  /// null: none.
  void limit(const char* key, Real& value) {
    const Json* json = find(key);
    if (json != nullptr) value = json->is_null() ? kUnlimited : finite(*json, key);
  }
  /// null, or nothing: the autopilot is asked.
  void number_or_ask(const char* key, Real& value, bool& asks) {
    const Json* json = find(key);
    asks = json == nullptr || json->is_null();
    if (!asks) value = finite(*json, key);
  }
  void seconds(const char* key, TimeUs& value) {
    const Json* json = find(key);
    if (json == nullptr) return;
    const double s = finite(*json, key);
    if (!(std::fabs(s) <= 1e6)) refuse(name(key) + " is out of range");
    value = std::llround(s * 1e6);
  }
  template <typename Integer>
  void count(const char* key, Integer& value, double most) {
    const Json* json = find(key);
    if (json == nullptr) return;
    const double n = finite(*json, key);
    if (!(n >= 0 && n <= most) || n != std::floor(n))
      refuse(name(key) + " is not a whole number from 0 on, or too large");
    value = static_cast<Integer>(n);
  }
  void flag(const char* key, bool& value) {
    if (const Json* json = find(key)) value = boolean(*json, prefix_ + key);
  }
  void vector(const char* key, Vector3& value) {
    const Json* json = find(key);
    if (json == nullptr) return;
    const std::vector<double> list = numbers(*json, prefix_ + key, 3);
    value = {list[0], list[1], list[2]};
  }
  template <typename Enum, std::size_t kCount>
  void choice(const char* key, Enum& value, const Words<Enum, kCount>& words) {
    const Json* json = find(key);
    if (json == nullptr) return;
    const std::string given = word(*json, prefix_ + key);
    std::string all;
    for (const auto& [each, text] : words) {
      if (given == text) {
        value = each;
        return;
      }
      all += (all.empty() ? "" : ", ") + std::string(text);
    }
    refuse(name(key) + " is none of " + all);
  }
  void vehicle(const char* key, std::optional<Vehicle>& value) {
    if (find(key) == nullptr) return;
    Vehicle read;
    group(key, [&] {
      number("mass_kg", read.mass);
      number("thrust_min_n", read.thrust_min);
      number("thrust_max_n", read.thrust_max);
      number("rate_max_rad_s", read.rate_max);
    });
    value = read;
  }
  template <typename Members>
  void group(const char* key, const Members& members) {
    const Json* json = find(key);
    if (json == nullptr) return;
    if (!json->is_object()) refuse(name(key) + " is not a JSON object");
    const Reader outer = *this;
    json_ = json;
    prefix_ += std::string(key) + ".";
    known_.clear();
    members();
    check_known();
    *this = outer;
  }
  void check_known() const {
    for (const auto& [key, value] : json_->items()) {
      if (known_.count(key) == 0) refuse(name(key) + " is not a known key");
    }
  }
  using JsonReader::refuse;

 private:
  const Json* find(const char* key) {
    known_.insert(key);
    return json_->contains(key) ? &(*json_)[key] : nullptr;
  }
  double finite(const Json& json, const std::string& key) const {
    const double value = JsonReader::number(json, prefix_ + key);
    if (!std::isfinite(value)) refuse(name(key) + " is not finite");
    return value;
  }
  [[nodiscard]] std::string name(const std::string& key) const { return "'" + prefix_ + key + "'"; }

  const Json* json_;
  std::string prefix_;
  std::set<std::string> known_;
};

/// The reverse.
class Writer {
 public:
  void number(const char* key, Real value) { (*at_)[key] = value; }
  void limit(const char* key, Real value) { (*at_)[key] = std::isfinite(value) ? Json(value) : Json(nullptr); }
  void number_or_ask(const char* key, Real value, bool asks) { (*at_)[key] = asks ? Json(nullptr) : Json(value); }
  void seconds(const char* key, TimeUs value) { (*at_)[key] = static_cast<double>(value) / 1e6; }
  template <typename Integer>
  void count(const char* key, Integer value, double most) {
    if (static_cast<double>(value) <= most) (*at_)[key] = value;
  }
  void flag(const char* key, bool value) { (*at_)[key] = value; }
  void vector(const char* key, const Vector3& value) { (*at_)[key] = {value.x(), value.y(), value.z()}; }
  template <typename Enum, std::size_t kCount>
  void choice(const char* key, Enum value, const Words<Enum, kCount>& words) {
    for (const auto& [each, text] : words) {
      if (each == value) (*at_)[key] = text;
    }
  }
  void vehicle(const char* key, const std::optional<Vehicle>& value) {
    if (!value) return;
    group(key, [&] {
      number("mass_kg", value->mass);
      number("thrust_min_n", value->thrust_min);
      number("thrust_max_n", value->thrust_max);
      number("rate_max_rad_s", value->rate_max);
    });
  }
  template <typename Members>
  void group(const char* key, const Members& members) {
    Json* const outer = at_;
    at_ = &((*at_)[key] = Json::object());
    members();
    at_ = outer;
  }
  [[nodiscard]] std::string text() const { return json_.dump(2); }

 private:
  Json json_ = {{"format", kFormat}};
  Json* at_ = &json_;
};

template <typename Visitor>
void visit_gains(Visitor& visitor, ControllerSettings& gains) {
  visitor.number("mass_kg", gains.mass);
  visitor.vector("k_position", gains.k_position);
  visitor.vector("k_velocity", gains.k_velocity);
  visitor.vector("k_attitude", gains.k_attitude);
  visitor.vector("k_rate", gains.k_rate);
  visitor.vector("k_attitude_rate", gains.k_attitude_rate);
  visitor.vector("k_position_form", gains.k_position_form);
  visitor.vector("k_velocity_form", gains.k_velocity_form);
  visitor.number("form_feedback_max_m_s2", gains.form_feedback_max);
  visitor.number("drag_1_s", gains.drag);
  visitor.number("tilt_max_rad", gains.tilt_max);
  visitor.number("thrust_min_m_s2", gains.thrust_min);
  visitor.number("thrust_max_m_s2", gains.thrust_max);
  visitor.vector("rate_max_rad_s", gains.rate_max);
}

template <typename Visitor>
void visit_supervisor(Visitor& visitor, SupervisorSettings& supervisor) {
  visitor.seconds("odometry_age_max_s", supervisor.odometry_age_max);
  visitor.seconds("link_age_max_s", supervisor.link_age_max);
  visitor.seconds("setpoint_age_max_s", supervisor.setpoint_age_max);
  visitor.seconds("setpoint_age_yield_s", supervisor.setpoint_age_yield);
  visitor.seconds("clock_gap_max_s", supervisor.clock_gap_max);
  visitor.seconds("blocked_patience_s", supervisor.blocked_patience);
  visitor.count("deadline_misses_max", supervisor.deadline_misses_max, 1e6);
  visitor.number("position_jump_m", supervisor.position_jump);
  visitor.flag("storage_needed", supervisor.storage_needed);
}

template <typename Visitor>
void visit_planning(Visitor& visitor, companion::PlanningSettings& planning) {
  visitor.seconds("latency_s", planning.latency);
  visitor.count("refinement", planning.budget.refinement, 1e15);
  visitor.count("deadline", planning.budget.deadline, 1e15);
  visitor.choice("corridor", planning.corridor, kCorridors);
  visitor.choice("search", planning.search.mode, kSearches);
  visitor.number("search_weight", planning.search.weight);
}

/// Every key once, for reading and for writing.
template <typename Visitor>
void visit(Visitor& visitor, Settings& settings) {
  visitor.count("system_id", settings.system_id, 255);
  visitor.choice("setpoint", settings.form, kForms);
  visitor.vector("start_m", settings.start);
  visitor.number("start_yaw_rad", settings.start_yaw);
  visitor.flag("engage_at_start", settings.engage_at_start);
  visitor.flag("land_at_end", settings.land_at_end);
  visitor.number("arrival_tolerance_m", settings.arrival_tolerance);
  visitor.group("limits", [&] {
    visitor.number("vmax_m_s", settings.limits.v_max);
    visitor.number("amax_m_s2", settings.limits.a_max);
    visitor.limit("jmax_m_s3", settings.limits.j_max);
    visitor.choice("norm", settings.limits.norm, kNorms);
    visitor.vehicle("vehicle", settings.limits.vehicle);
  });
  visitor.group("margins", [&] {
    visitor.number("vehicle_radius_m", settings.margins.vehicle_radius);
    visitor.number("map_error_m", settings.margins.map_error);
    visitor.number("numeric_margin_m", settings.margins.numeric_margin);
    visitor.number("heading_accuracy_rad", settings.margins.heading_accuracy);
    visitor.number("tube_position_m", settings.margins.tubes.position);
    visitor.number("tube_attitude_m", settings.margins.tubes.attitude);
    visitor.number("tube_rates_m", settings.margins.tubes.rates);
  });
  visitor.group("takeoff", [&] {
    visitor.number("height_m", settings.takeoff.height);
    visitor.number("tolerance_m", settings.takeoff.tolerance);
    visitor.seconds("patience_s", settings.takeoff.patience);
    visitor.seconds("standing_s", settings.takeoff.standing);
  });
  visitor.group("planning", [&] { visit_planning(visitor, settings.planning); });
  visitor.group("yaw", [&] {
    visitor.choice("mode", settings.yaw.mode, kYawModes);
    visitor.number("angle_rad", settings.yaw.angle);
    visitor.vector("point_m", settings.yaw.target);
    visitor.number("rate_max_rad_s", settings.yaw.rate_max);
    visitor.number("acceleration_max_rad_s2", settings.yaw.acceleration_max);
    visitor.number("look_ahead_s", settings.yaw.look_ahead);
    visitor.number("least_distance_m", settings.yaw.least_distance);
  });
  visitor.group("control", [&] {
    visitor.group("attitude", [&] { visit_gains(visitor, settings.control.attitude); });
    visitor.group("rates", [&] { visit_gains(visitor, settings.control.rates); });
  });
  visitor.group("delays", [&] {
    visitor.seconds("position_s", settings.delays.position);
    visitor.seconds("attitude_s", settings.delays.attitude);
    visitor.seconds("rates_s", settings.delays.rates);
  });
  visitor.group("predictor", [&] {
    visitor.number("response_time_s", settings.predictor.response_time);
    visitor.number("thrust_time_s", settings.predictor.thrust_time);
    visitor.number("disturbance_time_s", settings.predictor.disturbance_time);
    visitor.number("disturbance_max_m_s2", settings.predictor.disturbance_max);
    visitor.seconds("longest_s", settings.predictor.longest);
  });
  visitor.group("hover_thrust", [&] {
    visitor.number_or_ask("initial", settings.hover_thrust.initial, settings.asks_hover_thrust);
    visitor.number("least", settings.hover_thrust.least);
    visitor.number("most", settings.hover_thrust.most);
    visitor.number("time_constant_s", settings.hover_thrust.time_constant);
    visitor.seconds("window_s", settings.hover_thrust.window);
  });
  visitor.group("supervisor", [&] { visit_supervisor(visitor, settings.supervisor); });
}

Settings read(const std::string& where, const Json& json) {
  Reader reader(where, json);
  Settings settings;
  visit(reader, settings);
  reader.check_known();
  if (const char* fault = companion::find_fault(settings)) reader.refuse(fault);
  return settings;
}

}  // namespace

Settings load_config(const std::string& path) { return read(path, load_json(path, kFormat)); }

Settings parse_config(const std::string& where, std::string_view text) { return read(where, parse_json(where, text)); }

std::string config_text(const Settings& settings) {
  Writer writer;
  Settings written = settings;
  visit(writer, written);
  return writer.text();
}

}  // namespace swiftlet::tools
