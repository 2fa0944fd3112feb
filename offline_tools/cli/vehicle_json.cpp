#include "cli/vehicle_json.hpp"

namespace swiftlet::tools {

Json vehicle_json(const Vehicle& vehicle) {
  return {{"mass_kg", vehicle.mass},
          {"thrust_min_n", vehicle.thrust_min},
          {"thrust_max_n", vehicle.thrust_max},
          {"rate_max_rad_s", vehicle.rate_max}};
}

Vehicle read_vehicle(const JsonReader& reader, const Json& json, const std::string& what) {
  const auto value = [&](const char* key) { return reader.number(reader.member(json, key), what + "." + key); };
  const Vehicle vehicle{value("mass_kg"), value("thrust_min_n"), value("thrust_max_n"), value("rate_max_rad_s")};
  FlightLimits limits;
  limits.v_max = limits.a_max = 1;
  limits.vehicle = vehicle;
  if (!is_usable(limits)) reader.refuse("'" + what + "' is no vehicle that can hover");
  return vehicle;
}

}  // namespace swiftlet::tools
