#include "cli/vehicle_file.hpp"

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "cli/json_reader.hpp"

namespace swiftlet::tools {
namespace {

constexpr const char* kFormat = "swiftlet-vehicle/1";

class VehicleReader : private JsonReader {
 public:
  using JsonReader::JsonReader;

  VehicleFile read(const Json& json) {
    check_format(json, kFormat);
    check_keys(json, "", {"format", "mass_kg", "thrust_min_n", "thrust_max_n", "rate_max_rad_s", "simulation"});
    VehicleFile file{};
    VehicleModel& model = file.model;
    model.mass = positive(member(json, "mass_kg"), "mass_kg");
    model.thrust_min = at_least_zero(member(json, "thrust_min_n"), "thrust_min_n");
    model.thrust_max = positive(member(json, "thrust_max_n"), "thrust_max_n");
    model.rate_max = positive(member(json, "rate_max_rad_s"), "rate_max_rad_s");
    const double weight = model.mass * kGravity;
    if (!(model.thrust_min < weight && weight < model.thrust_max)) {
      refuse("cannot hover: 'thrust_min_n' < 'mass_kg' * 9.80665 < 'thrust_max_n' must hold");
    }
    file.hover_thrust = hover_fraction(model);
    if (json.contains("simulation")) read_simulation(json["simulation"], file);
    return file;
  }

 private:
  void read_simulation(const Json& json, VehicleFile& file) {
    if (!json.is_object()) refuse("'simulation' is not a JSON object");
    check_keys(json, "simulation.",
               {"inertia_kg_m2", "motor_lag_s", "arm_m", "torque_per_thrust_m", "drag_n_per_mps",
                "angular_drag_nm_per_rad_s", "hover_thrust"});
    VehicleModel& model = file.model;
    if (json.contains("inertia_kg_m2")) {
      const std::vector<double> inertia = numbers(json["inertia_kg_m2"], "simulation.inertia_kg_m2", 3);
      if (!(std::min({inertia[0], inertia[1], inertia[2]}) > 0)) {
        refuse("'simulation.inertia_kg_m2' is not greater than 0");
      }
      model.inertia = {inertia[0], inertia[1], inertia[2]};
    }
    const auto take = [&](const char* key, double& into, auto check) {
      if (json.contains(key)) into = (this->*check)(json[key], std::string("simulation.") + key);
    };
    take("motor_lag_s", model.motor_lag, &VehicleReader::motor_lag);
    take("arm_m", model.arm, &VehicleReader::positive);
    take("torque_per_thrust_m", model.torque_per_thrust, &VehicleReader::positive);
    take("drag_n_per_mps", model.drag, &VehicleReader::at_least_zero);
    take("angular_drag_nm_per_rad_s", model.angular_drag, &VehicleReader::at_least_zero);
    take("hover_thrust", file.hover_thrust, &VehicleReader::share);
  }

  void check_keys(const Json& json, const std::string& prefix, std::initializer_list<std::string_view> known) const {
    for (const auto& [key, value] : json.items()) {
      if (std::find(known.begin(), known.end(), key) == known.end())
        refuse(std::string("'").append(prefix).append(key).append("' is not a known key"));
    }
  }
  double positive(const Json& json, const std::string& what) const {
    const double value = number(json, what);
    if (!(value > 0 && value <= 1e6)) refuse("'" + what + "' is not greater than 0 and at most 1e6");
    return value;
  }
  double at_least_zero(const Json& json, const std::string& what) const {
    const double value = number(json, what);
    if (!(value >= 0 && value <= 1e6)) refuse("'" + what + "' is not from 0 to 1e6");
    return value;
  }
  /// The integrator's step of a millisecond must stay well below it.
  double motor_lag(const Json& json, const std::string& what) const {
    const double value = number(json, what);
    if (!(value >= 0.005 && value <= 1)) refuse("'" + what + "' is not from 0.005 to 1");
    return value;
  }
  double share(const Json& json, const std::string& what) const {
    const double value = number(json, what);
    if (!(value >= 0.1 && value <= 0.8)) refuse("'" + what + "' is not from 0.1 to 0.8");
    return value;
  }
};

}  // namespace

VehicleFile load_vehicle(const std::string& path) { return VehicleReader(path).read(load_json(path, kFormat)); }

}  // namespace swiftlet::tools
