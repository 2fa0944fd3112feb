#pragma once
#include <cstdint>

#include "swiftlet/flight_limits.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// What the autopilot is sent; how well it is followed depends on it.
enum class SetpointForm : std::uint8_t { kPosition, kAttitude, kRates };

/// Largest distance between vehicle and reference, by the form in use [m]. The position form leaves the loop to the
/// autopilot: a real PX4 with its default gains was seen 0.45 m off a 1 m/s square.
struct TrackingTubes {
  Real position = Real(0.5);
  Real attitude = Real(0.15);
  Real rates = Real(0.15);
};
Real tube_of(const TrackingTubes& tubes, SetpointForm form);

/// What the map's inflation must cover, each share apart [m]. The vehicle's centre keeps the map's radius from every
/// obstacle; the shares are distances that all can point at the same obstacle at once, so they add up.
struct MarginLedger {
  Real vehicle_radius = 0;  ///< centre to the outermost part of the vehicle, propellers included
  Real map_error = 0;       ///< scan, registration, and the map frame's alignment with the autopilot's
  Real tracking_tube = 0;   ///< vehicle to reference: tube_of; the supervisor brakes beyond it
  Real numeric_margin = 0;  ///< the certificate's tolerance
  /// [rad] largest error of the autopilot's heading when its frame is tied to the map's. It stays, and puts the vehicle
  /// that much times the level distance from the place of the tie aside. 0: not budgeted.
  Real heading_accuracy = 0;
};

enum class MarginVerdict : std::uint8_t {
  kCovered,      ///< the map's radius covers the sum
  kMapTooTight,  ///< it does not: do not fly
  kBadNumber,    ///< a share, or the radius, is negative or not finite: do not fly
};

struct MarginReport {
  MarginVerdict verdict = MarginVerdict::kBadNumber;
  Real required = 0;  ///< [m] sum of the shares, at the place of the tie
  Real reach = 0;  ///< [m] level, from the place of the tie: how far the rest of the radius covers the heading's error
  Real missing = 0;  ///< [m] by which the map's radius is too small, > 0 with kMapTooTight only
};

/// Compares the ledger with the radius that the map was inflated by.
MarginReport check_margins(const MarginLedger& ledger, Real map_radius);

/// English phrase for people and logs.
const char* describe(MarginVerdict verdict);

}  // namespace swiftlet
