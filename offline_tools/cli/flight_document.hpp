#pragma once
#include <deque>

#include "cli/json.hpp"
#include "cli/map_file.hpp"
#include "fly/flight.hpp"

namespace swiftlet::tools {

/// The format swiftlet-flight/1 (contract.md). `plan` is the first plan that was flown, or the one that kept the flight
/// from beginning.
Json flight_document(const MapFile& map, const FlightRequest& request, const FlightReport& report,
                     const std::deque<FlownPlan>& plans, Json plan);

/// swiftlet-plan/1 of a plan that was made in a flight.
Json plan_document(const MapFile& map, const FlownPlan& plan);

}  // namespace swiftlet::tools
