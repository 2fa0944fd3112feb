#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <variant>
#include <vector>

#include "companion/word.hpp"
#include "flight/ulog_reader.hpp"
#include "swiftlet/flight_time.hpp"

namespace swiftlet::tools {

/// The CRC-32 of a map that was given in place of the one before.
struct MapChange {
  std::uint32_t crc32 = 0;
};

/// What entered a companion in one step, and before it since the one before.
struct FlightStep {
  TimeUs now = 0;
  std::vector<std::variant<companion::Word, MapChange>> before;  ///< in order
  std::vector<std::vector<std::byte>> reads;                     ///< what each Uart::read gave
  std::map<std::uint32_t, std::size_t> short_writes;             ///< number of a write: bytes that the device took
  std::uint32_t plans_done = 0;
  std::uint32_t writes = 0;    ///< since the step before
  std::uint32_t sent_crc = 0;  ///< CRC-32 of all bytes that were offered to the device
};

/// The inputs of a flight, from the topic swiftlet_input; the last step only when it is complete. Error: exit status 3
/// and a line, for a log without them or a damaged one.
Expected<std::vector<FlightStep>> flight_inputs(const Ulog& log);

}  // namespace swiftlet::tools
