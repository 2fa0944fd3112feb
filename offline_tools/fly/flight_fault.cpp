#include "fly/flight_fault.hpp"

#include <array>

namespace swiftlet::tools {
namespace {

struct KindText {
  CompanionFaultKind kind;
  const char* name;
  const char* meaning;
};

constexpr double kUsualSleep = 0.5;  // [s]
constexpr std::array kKinds{
    KindText{CompanionFaultKind::kSleep, "sleep", "the companion is not run (0.5 s)"},
    KindText{CompanionFaultKind::kClockStep, "clock-step", "the companion's own clock jumps 5 s ahead"},
    KindText{CompanionFaultKind::kMapReplaced, "map-replaced",
             "the companion is given its map anew, under another CRC"},
    KindText{CompanionFaultKind::kStorageFull, "storage-full", "the companion's log cannot grow any more"},
};

}  // namespace

std::optional<FlightFault> parse_flight_fault(std::string_view text) {
  const std::size_t at_sign = text.find('@');
  if (at_sign == std::string_view::npos) return std::nullopt;
  if (const std::optional<Fault> fault = parse_fault(text)) return *fault;
  for (const KindText& kind : kKinds) {
    if (text.substr(0, at_sign) != kind.name) continue;
    // The times are written as for a fault of the autopilot's side that has a duration, or has none.
    const bool lasts = kind.kind == CompanionFaultKind::kSleep;
    const std::string times(text.substr(at_sign));
    const std::optional<Fault> alike = parse_fault((lasts ? "stall" : "clock-jump") + times);
    if (!alike) return std::nullopt;
    const bool usual = times.find('+') == std::string::npos;
    return CompanionFault{kind.kind, alike->at, lasts && usual ? kUsualSleep : alike->duration};
  }
  return std::nullopt;
}

const char* describe(CompanionFaultKind kind) { return kKinds[static_cast<std::size_t>(kind)].name; }

const char* describe(const FlightFault& fault) {
  return std::visit([](const auto& either) { return describe(either.kind); }, fault);
}

double begin_of(const FlightFault& fault) {
  return std::visit([](const auto& either) { return either.at; }, fault);
}

std::string list_flight_faults() {
  std::string text = list_faults();
  for (const KindText& kind : kKinds) {
    std::string line = std::string("  ") + kind.name + "@T";
    if (kind.kind == CompanionFaultKind::kSleep) line += "[+D]";
    line.resize(24, ' ');
    text += line + kind.meaning + '\n';
  }
  return text;
}

}  // namespace swiftlet::tools
