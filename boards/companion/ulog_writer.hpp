#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

#include "swiftlet/flight_time.hpp"
#include "swiftlet/hal/storage.hpp"

namespace swiftlet::companion {

/// Bytes that a ULog format string promises: "name:type field;type[n] field;"; 0 when a type is not one of ULog's.
consteval std::size_t ulog_format_size(std::string_view format);

/// Writes the ULog format, version 1, which PX4's tools read (https://docs.px4.io/main/en/dev_log/ulog_file_format).
/// Append only, no heap, never blocks longer than the storage does. In order: begin; the definitions (format, info,
/// parameter); the subscriptions; then data, texts and further infos. Bytes are collected and reach the storage by
/// flush, or when kBuffer of them wait.
///
/// When the storage refuses once, the log is over: full() from then on, nothing more is appended, and what was stored
/// ends within a message at worst, which readers take for a truncated file.
class UlogWriter {
 public:
  static constexpr std::size_t kBuffer = 2048;
  static constexpr std::size_t kLongestName = 64;  ///< characters of an info's or parameter's key

  explicit UlogWriter(hal::Storage& storage) : storage_(storage) {}
  UlogWriter(const UlogWriter&) = delete;
  UlogWriter& operator=(const UlogWriter&) = delete;

  /// Begins the log `name`, which must not exist yet; `name` outlives the writer. False, and full(), otherwise.
  bool begin(std::string_view name, TimeUs now);

  // Definitions. `format` and keys are ASCII. Texts are cut at 60,000 characters.
  void format(std::string_view format);
  void info(std::string_view key, std::string_view value);
  void info(std::string_view key, std::uint32_t value);
  void parameter(std::string_view key, float value);

  /// Messages of the format `name` will carry `id`; each id once.
  void subscribe(std::uint16_t id, std::string_view name);

  /// One message of a subscribed topic; `bytes` are as its format says, little-endian.
  void data(std::uint16_t id, std::span<const std::byte> bytes);

  /// A line for people; `severity` as MAVLink and syslog count, 0 to 7.
  void text(TimeUs now, std::uint8_t severity, std::string_view text);

  /// Hands everything to the storage.
  void flush();

  /// The storage refused, or the log was never begun: nothing is kept any more.
  [[nodiscard]] bool full() const { return !open_; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }  ///< written so far

 private:
  void message(char type, std::size_t size);
  template <typename Number>
  void pair(char type, std::string_view type_name, std::string_view key, Number value) {
    key = {key.data(), std::min(key.size(), kLongestName)};
    message(type, 1 + type_name.size() + key.size() + sizeof(value));
    put(static_cast<std::uint8_t>(type_name.size() + key.size()));
    put(type_name);
    put(key);
    put(value);
  }
  void put(std::span<const std::byte> bytes);
  void put(std::string_view text) { put(std::as_bytes(std::span(text))); }
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void put(Number number) { put(std::as_bytes(std::span(&number, 1))); }

  hal::Storage& storage_;
  std::string_view name_;
  bool open_ = false;
  std::uint64_t bytes_ = 0;
  std::array<std::byte, kBuffer> buffer_{};
  std::size_t waiting_ = 0;
};

static_assert(std::endian::native == std::endian::little, "ULog is little-endian");

namespace internal {

struct UlogType {
  std::string_view name;
  std::size_t size;
};
inline constexpr std::array<UlogType, 12> kUlogTypes{{{"int8_t", 1},
                                                      {"uint8_t", 1},
                                                      {"int16_t", 2},
                                                      {"uint16_t", 2},
                                                      {"int32_t", 4},
                                                      {"uint32_t", 4},
                                                      {"int64_t", 8},
                                                      {"uint64_t", 8},
                                                      {"float", 4},
                                                      {"double", 8},
                                                      {"bool", 1},
                                                      {"char", 1}}};

/// Of "float" or "float[3]"; 0 when it is no type.
constexpr std::size_t ulog_type_size(std::string_view type) {
  const std::size_t bracket = type.find('[');
  std::size_t count = 1;
  if (bracket != std::string_view::npos) {
    count = 0;
    for (std::size_t i = bracket + 1; i < type.size() && type[i] != ']'; ++i) {
      count = 10 * count + static_cast<std::size_t>(type[i] - '0');
    }
  }
  for (const UlogType& known : kUlogTypes) {
    if (known.name == type.substr(0, bracket)) return known.size * count;
  }
  return 0;
}

}  // namespace internal

consteval std::size_t ulog_format_size(std::string_view format) {
  std::size_t total = 0;
  std::string_view rest = format.substr(format.find(':') + 1);
  while (!rest.empty()) {
    const std::size_t size = internal::ulog_type_size(rest.substr(0, rest.find(' ')));
    if (size == 0) return 0;
    total += size;
    rest = rest.substr(rest.find(';') + 1);
  }
  return total;
}

}  // namespace swiftlet::companion
