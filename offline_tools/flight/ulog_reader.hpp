#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "map/error.hpp"

namespace swiftlet::tools {

/// One field of a topic.
struct UlogField {
  std::string type;  ///< "float"
  std::string name;
  std::size_t count = 1;   ///< of an array
  std::size_t offset = 0;  ///< in the message
};

/// A topic with its fields; those of other logs that hold further formats are not taken apart: no fields.
struct UlogTopic {
  std::string name;
  std::vector<UlogField> fields;
  std::size_t size = 0;  ///< bytes of a message; 0 when it was not taken apart
};

/// A message of a topic, or a text.
struct UlogEntry {
  std::size_t offset = 0;  ///< in the file
  bool is_text = false;
  std::uint16_t topic = 0;    ///< its number in the log
  std::uint8_t severity = 6;  ///< of a text, 0 to 7
  std::uint64_t time = 0;     ///< [us] of a text
  std::span<const std::byte> bytes;

  [[nodiscard]] std::string_view text() const { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }
};

/// A flight log in the ULog format. Movable: entries point into the vector's memory, which moves along.
struct Ulog {
  std::string path;
  std::vector<std::byte> bytes;
  std::uint64_t start = 0;                       ///< [us]
  std::map<std::string, std::string> texts;      ///< information of type char[]
  std::map<std::string, std::uint32_t> numbers;  ///< ... of type uint32_t
  std::map<std::string, float> parameters;
  std::map<std::uint16_t, UlogTopic> topics;
  std::vector<UlogEntry> entries;  ///< in the order of the file
  bool truncated = false;          ///< it ends within a message: the storage was full, or the power went
  std::uint32_t dropouts = 0;

  /// The number of the topic `name`.
  [[nodiscard]] std::optional<std::uint16_t> find_topic(std::string_view name) const;
};

/// Reads a log; what PX4 writes is read as well, and refused where this reader could misunderstand it. Error: exit
/// status 3 and a line that names the file and the byte, for anything that is no log or damaged. A log that ends within
/// its last message is good up to there.
Expected<Ulog> parse_ulog(const std::string& path, std::vector<std::byte> bytes);
Expected<Ulog> read_ulog(const std::string& path);

}  // namespace swiftlet::tools
