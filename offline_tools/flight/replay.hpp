#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "companion/companion.hpp"
#include "flight/flight_inputs.hpp"
#include "flight/ulog_reader.hpp"

namespace swiftlet::tools {

/// A map of a flight, and where it was then.
struct NamedMap {
  std::uint32_t crc32 = 0;
  std::string file;
};

/// The maps that the log names, the one that the flight began in first. Error: exit status 3 and a line, when it does
/// not name that one.
Expected<std::vector<NamedMap>> named_maps(const Ulog& log);

/// What a replay needs beside the log.
struct ReplayWorld {
  std::span<const BoxGraphView> maps;  ///< the first is the one that the flight began in
  companion::Settings settings;        ///< the log's text `swiftlet_settings`, read
  companion::Memory memory;
  PlannerSpans planner;
};

struct ReplayDifference {
  TimeUs time = 0;   ///< of the companion's clock
  std::string what;  ///< for people
};

struct ReplayReport {
  std::size_t steps = 0;
  std::size_t plans = 0;                       ///< that were committed
  std::size_t messages = 0;                    ///< of all topics, and texts
  std::optional<ReplayDifference> difference;  ///< the first
};

/// Gives a companion what entered the one that wrote the log, step by step, and lets it write a log of its own: what
/// was sent, each plan, all that was told must be the same to the last bit, as far as the log reaches.
/// Error: exit status 3 and a line, for a log that is damaged or cannot be replayed, or flown in another map.
Expected<ReplayReport> replay(const Ulog& log, const ReplayWorld& world);

}  // namespace swiftlet::tools
