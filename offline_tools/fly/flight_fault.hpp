#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "sim/fault.hpp"

namespace swiftlet::tools {

/// What can go wrong on the companion's own side of a simulated flight.
enum class CompanionFaultKind : std::uint8_t {
  kSleep,        ///< it is not run for a while
  kClockStep,    ///< its clock jumps 5 s ahead
  kMapReplaced,  ///< its map is another file's from then on
  kStorageFull,  ///< its log cannot grow any more
};

struct CompanionFault {
  CompanionFaultKind kind;
  double at;        ///< [s] from the start of the simulation
  double duration;  ///< [s] kSleep alone
};

inline constexpr std::chrono::seconds kClockStep{5};

/// A fault of either side.
using FlightFault = std::variant<Fault, CompanionFault>;

/// As parse_fault, for the faults of both sides.
std::optional<FlightFault> parse_flight_fault(std::string_view text);

const char* describe(CompanionFaultKind kind);  ///< its name in `parse_flight_fault`
const char* describe(const FlightFault& fault);
double begin_of(const FlightFault& fault);  ///< [s]

/// A line for each kind: name, meaning and usual duration.
std::string list_flight_faults();

}  // namespace swiftlet::tools
