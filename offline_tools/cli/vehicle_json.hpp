#pragma once
#include <string>

#include "cli/json.hpp"
#include "cli/json_reader.hpp"
#include "swiftlet/flight_limits.hpp"

namespace swiftlet::tools {

/// What a plan says of the vehicle whose thrust and body rates it keeps: the same keys as in a vehicle file.
Json vehicle_json(const Vehicle& vehicle);

/// The same, read; `what` names it in a fault, which throws Failure (kBadFile).
Vehicle read_vehicle(const JsonReader& reader, const Json& json, const std::string& what);

}  // namespace swiftlet::tools
