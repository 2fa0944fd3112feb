#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "report/flight_record.hpp"

namespace swiftlet::tools {

struct FlightReportInput {
  const nlohmann::ordered_json& flight;  ///< swiftlet-flight/1; fields may be absent
  const FlightRecord& record;
  std::string title;  ///< UTF-8, plain text
};

/// One self-contained HTML page that replays a flight: 3-D view, timeline, plots and numbers, working offline and, but
/// for the view, without WebGL. It carries at most 250,000 obstacle boxes, the largest; 30,000 moments, each with the
/// worst tracking error since the one before; and the plans longest in force with 10,000 boxes in all: below 10 MB.
std::string flight_report_html(const FlightReportInput& input);

}  // namespace swiftlet::tools
