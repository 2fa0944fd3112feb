#include "swiftlet/margin_ledger.hpp"

namespace swiftlet {
namespace {

constexpr Real kLargestShare = Real(1e3);  // [m]

bool is_usable(Real share) { return share >= 0 && share <= kLargestShare; }  // false for NaN

}  // namespace

Real tube_of(const TrackingTubes& tubes, SetpointForm form) {
  switch (form) {
    case SetpointForm::kAttitude:
      return tubes.attitude;
    case SetpointForm::kRates:
      return tubes.rates;
    case SetpointForm::kPosition:
      break;
  }
  return tubes.position;
}

MarginReport check_margins(const MarginLedger& ledger, Real map_radius) {
  MarginReport report;
  if (!is_usable(ledger.vehicle_radius) || !is_usable(ledger.map_error) || !is_usable(ledger.tracking_tube) ||
      !is_usable(ledger.numeric_margin) || !is_usable(ledger.heading_accuracy) || !is_usable(map_radius)) {
    return report;
  }
  report.required = ledger.vehicle_radius + ledger.map_error + ledger.tracking_tube + ledger.numeric_margin;
  const bool covered = report.required <= map_radius;
  report.verdict = covered ? MarginVerdict::kCovered : MarginVerdict::kMapTooTight;
  report.missing = covered ? Real(0) : report.required - map_radius;
  if (covered) {
    report.reach = ledger.heading_accuracy > 0 ? (map_radius - report.required) / ledger.heading_accuracy : kUnlimited;
  }
  return report;
}

const char* describe(MarginVerdict verdict) {
  switch (verdict) {
    case MarginVerdict::kCovered:
      return "the map's radius covers vehicle, map error, tracking and numerics";
    case MarginVerdict::kMapTooTight:
      return "the map's radius is smaller than vehicle, map error, tracking and numerics together";
    case MarginVerdict::kBadNumber:
      return "a margin is negative or not a number";
  }
  return "unknown verdict";
}

}  // namespace swiftlet
