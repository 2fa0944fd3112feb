#include "companion/settings.hpp"

#include <cmath>

namespace swiftlet::companion {
namespace {

constexpr TimeUs kLongest = 60 * kSecondUs;

bool is_share(Real value) { return value >= 0 && value <= 100; }  // [m]; false for NaN
bool is_time(TimeUs value) { return value >= 0 && value <= kLongest; }

}  // namespace

const char* find_fault(const Settings& settings) {
  if (!is_usable(settings.limits)) return "limits: not positive, out of range, or a vehicle that cannot hover";
  if (!settings.start.allFinite() || !std::isfinite(settings.start_yaw)) return "start: not finite";
  if (!(settings.takeoff.height > 0 && settings.takeoff.height <= 100)) return "take-off height: not in 0 to 100 m";
  if (!(settings.takeoff.tolerance > 0)) return "take-off tolerance: not positive";
  if (!(settings.arrival_tolerance > 0)) return "arrival tolerance: not positive";
  const Margins& margins = settings.margins;
  for (const Real share : {margins.vehicle_radius, margins.map_error, margins.numeric_margin, margins.tubes.position,
                           margins.tubes.attitude, margins.tubes.rates}) {
    if (!is_share(share)) return "margins: not in 0 to 100 m";
  }
  for (const TimeUs time : {settings.takeoff.patience, settings.takeoff.standing, settings.planning.latency,
                            settings.delays.position, settings.delays.attitude, settings.delays.rates}) {
    if (!is_time(time)) return "a time: not in 0 to 60 s";
  }
  const PredictorSettings& predictor = settings.predictor;
  for (const Real share :
       {predictor.response_time, predictor.thrust_time, predictor.disturbance_time, predictor.disturbance_max}) {
    if (!is_share(share)) return "predictor: not in 0 to 100";
  }
  if (!(settings.yaw.rate_max > 0 && settings.yaw.acceleration_max > 0)) return "yaw limits: not positive";
  return nullptr;
}

MarginReport margins_of(const Settings& settings, Real map_radius) {
  MarginLedger ledger;
  ledger.vehicle_radius = settings.margins.vehicle_radius;
  ledger.map_error = settings.margins.map_error;
  ledger.tracking_tube = tube_of(settings.margins.tubes, settings.form);
  ledger.numeric_margin = settings.margins.numeric_margin;
  return check_margins(ledger, map_radius);
}

}  // namespace swiftlet::companion
