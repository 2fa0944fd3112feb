#include "flight/ulog_reader.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "companion/ulog_writer.hpp"
#include "map/file_io.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::string_view kMagic = "ULog\x01\x12\x35";
constexpr std::size_t kHeaderBytes = 16;
constexpr std::size_t kMessageHeader = 3;
constexpr std::string_view kKnownTypes = "BFIMPQARDLCSO";

template <typename Number>
Number number_at(std::span<const std::byte> bytes, std::size_t offset) {
  Number number{};
  std::memcpy(&number, bytes.data() + offset, sizeof(number));
  return number;
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A key as information and parameters have it: "float MC_ROLL_P", or "char[5] sys_name".
struct TypedKey {
  std::string_view type;
  std::string_view name;
  std::span<const std::byte> value;
};

std::optional<TypedKey> typed_key(std::span<const std::byte> message) {
  if (message.empty()) return std::nullopt;
  const auto size = std::to_integer<std::size_t>(message[0]);
  if (message.size() < 1 + size) return std::nullopt;
  const std::string_view key = text_of(message.subspan(1, size));
  const std::size_t space = key.find(' ');
  if (space == std::string_view::npos || space + 1 == key.size()) return std::nullopt;
  return TypedKey{key.substr(0, space), key.substr(space + 1), message.subspan(1 + size)};
}

/// The element count of "float[3]" or "float"; nothing when the brackets hold no number.
std::optional<std::size_t> count_of(std::string_view type) {
  const std::size_t bracket = type.find('[');
  if (bracket == std::string_view::npos) return 1;
  const std::string_view digits = type.substr(bracket + 1, type.size() - bracket - 2);
  if (type.back() != ']' || digits.empty() || digits.size() > 5) return std::nullopt;
  std::size_t count = 0;
  for (const char c : digits) {
    if (c < '0' || c > '9') return std::nullopt;
    count = 10 * count + static_cast<std::size_t>(c - '0');
  }
  return count;
}

std::optional<std::size_t> size_of(std::string_view element) {
  for (const auto& known : companion::internal::kUlogTypes) {
    if (known.name == element) return known.size;
  }
  return std::nullopt;
}

class Parser {
 public:
  explicit Parser(Ulog& log) : log_(log) {}

  std::optional<Error> run() {
    const std::span<const std::byte> bytes = log_.bytes;
    if (!text_of(bytes).starts_with(kMagic)) return refuse("is no flight log: it does not begin with 'ULog'");
    if (bytes.size() < kHeaderBytes) return refuse("ends within its header");
    if (std::to_integer<int>(bytes[kMagic.size()]) > 1) return refuse("is of a newer version of ULog than 1");
    log_.start = number_at<std::uint64_t>(bytes, 8);
    for (at_ = kHeaderBytes; at_ < bytes.size();) {
      if (auto error = take_message(bytes.subspan(at_))) return error;
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] Error refuse(const std::string& what) const { return {kExitBadFile, log_.path + ": " + what}; }
  [[nodiscard]] Error damaged(const std::string& what) const {
    return refuse("damaged at byte " + std::to_string(at_) + ": " + what + "; nothing after it can be trusted");
  }

  std::optional<Error> take_message(std::span<const std::byte> rest) {
    if (rest.size() < kMessageHeader) return end_within_message();
    const auto size = number_at<std::uint16_t>(rest, 0);
    const auto type = static_cast<char>(rest[2]);
    if (kKnownTypes.find(type) == std::string_view::npos) {
      return damaged("a message of the unknown type " + std::to_string(std::to_integer<int>(rest[2])));
    }
    if (rest.size() < kMessageHeader + size) return end_within_message();
    if (auto error = take(type, rest.subspan(kMessageHeader, size))) return error;
    at_ += kMessageHeader + size;
    return std::nullopt;
  }

  std::optional<Error> end_within_message() {
    log_.truncated = true;
    at_ = log_.bytes.size();
    return std::nullopt;
  }

  std::optional<Error> take(char type, std::span<const std::byte> message) {
    switch (type) {
      case 'B':
        return take_flags(message);
      case 'F':
        return take_format(message);
      case 'I':
        return take_info(message);
      case 'P':
        return take_parameter(message);
      case 'A':
        return take_subscription(message);
      case 'D':
        return take_data(message);
      case 'L':
        return take_text(message);
      case 'O':
        ++log_.dropouts;
        return std::nullopt;
      default:
        return std::nullopt;  // more information, defaults, tagged texts, the end of a subscription, marks
    }
  }

  std::optional<Error> take_flags(std::span<const std::byte> message) {
    constexpr std::size_t kFlags = 8;
    if (message.size() < 2 * kFlags) return damaged("flags of " + std::to_string(message.size()) + " bytes");
    const auto incompatible = message.subspan(kFlags, kFlags);
    const bool any =
        std::any_of(incompatible.begin(), incompatible.end(), [](std::byte b) { return b != std::byte{0}; });
    if (any) return refuse("uses a feature of ULog that this reader does not know (appended data)");
    return std::nullopt;
  }

  std::optional<Error> take_format(std::span<const std::byte> message) {
    const std::string_view format = text_of(message);
    const std::size_t colon = format.find(':');
    if (colon == std::string_view::npos || colon == 0) return damaged("a format without a name");
    UlogTopic topic;
    topic.name = format.substr(0, colon);
    bool known = true;
    for (std::string_view rest = format.substr(colon + 1); !rest.empty();) {
      const std::size_t end = rest.find(';');
      const std::string_view field = rest.substr(0, end);
      const std::size_t space = field.find(' ');
      if (end == std::string_view::npos || space == std::string_view::npos) return damaged("a field without a name");
      known = known && add_field(field.substr(0, space), field.substr(space + 1), topic);
      rest = rest.substr(end + 1);
    }
    if (!known) {
      topic.fields.clear();
      topic.size = 0;
    }
    formats_[topic.name] = std::move(topic);
    return std::nullopt;
  }

  /// False for a type that is not one of ULog's own.
  static bool add_field(std::string_view type, std::string_view name, UlogTopic& topic) {
    const std::string_view element = type.substr(0, type.find('['));
    const auto count = count_of(type);
    const auto size = size_of(element);
    if (!count || !size) return false;
    topic.fields.push_back({std::string(element), std::string(name), *count, topic.size});
    topic.size += *count * *size;
    return true;
  }

  std::optional<Error> take_info(std::span<const std::byte> message) {
    const auto key = typed_key(message);
    if (!key) return damaged("information without a key");
    if (key->type.starts_with("char[")) log_.texts[std::string(key->name)] = text_of(key->value);
    if (key->type == "uint32_t" && key->value.size() == 4) {
      log_.numbers[std::string(key->name)] = number_at<std::uint32_t>(key->value, 0);
    }
    return std::nullopt;
  }

  std::optional<Error> take_parameter(std::span<const std::byte> message) {
    const auto key = typed_key(message);
    if (!key || key->value.size() != 4) return damaged("a parameter without a key or value");
    log_.parameters[std::string(key->name)] = key->type == "float"
                                                  ? number_at<float>(key->value, 0)
                                                  : static_cast<float>(number_at<std::int32_t>(key->value, 0));
    return std::nullopt;
  }

  std::optional<Error> take_subscription(std::span<const std::byte> message) {
    constexpr std::size_t kName = 3;  // after instance and number
    if (message.size() <= kName) return damaged("a subscription without a name");
    const auto id = number_at<std::uint16_t>(message, 1);
    const auto format = formats_.find(std::string(text_of(message.subspan(kName))));
    if (format == formats_.end()) return damaged("a topic without a format");
    if (log_.topics.contains(id)) return damaged("topic " + std::to_string(id) + " begins twice");
    log_.topics[id] = format->second;
    return std::nullopt;
  }

  std::optional<Error> take_data(std::span<const std::byte> message) {
    if (message.size() < 2) return damaged("data without a topic");
    const auto id = number_at<std::uint16_t>(message, 0);
    const auto topic = log_.topics.find(id);
    if (topic == log_.topics.end()) return damaged("data of topic " + std::to_string(id) + ", which has not begun");
    const auto bytes = message.subspan(2);
    if (topic->second.size > 0 && !fits(topic->second, bytes.size())) {
      return damaged(topic->second.name + " of " + std::to_string(bytes.size()) + " bytes, its format has " +
                     std::to_string(topic->second.size));
    }
    log_.entries.push_back({at_, false, id, 0, 0, bytes});
    return std::nullopt;
  }

  /// Padding at the end may be left out.
  static bool fits(const UlogTopic& topic, std::size_t size) {
    const UlogField& last = topic.fields.back();
    return size == topic.size || (last.name.starts_with("_padding") && size == last.offset);
  }

  std::optional<Error> take_text(std::span<const std::byte> message) {
    constexpr std::size_t kText = 9;  // after severity and time
    if (message.size() < kText) return damaged("a text without a time");
    const auto severity = static_cast<std::uint8_t>((std::to_integer<unsigned>(message[0]) - '0') & 7U);
    log_.entries.push_back({at_, true, 0, severity, number_at<std::uint64_t>(message, 1), message.subspan(kText)});
    return std::nullopt;
  }

  Ulog& log_;
  std::size_t at_ = 0;
  std::map<std::string, UlogTopic> formats_;
};

}  // namespace

std::optional<std::uint16_t> Ulog::find_topic(std::string_view name) const {
  for (const auto& [id, topic] : topics) {
    if (topic.name == name) return id;
  }
  return std::nullopt;
}

Expected<Ulog> parse_ulog(const std::string& path, std::vector<std::byte> bytes) {
  Ulog log;
  log.path = path;
  log.bytes = std::move(bytes);
  if (auto error = Parser(log).run()) return tl::unexpected(std::move(*error));
  return log;
}

Expected<Ulog> read_ulog(const std::string& path) {
  auto bytes = read_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return parse_ulog(path, std::move(*bytes));
}

}  // namespace swiftlet::tools
