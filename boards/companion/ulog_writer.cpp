#include "companion/ulog_writer.hpp"

#include <algorithm>

namespace swiftlet::companion {
namespace {

constexpr std::array<std::uint8_t, 8> kMagic{'U', 'L', 'o', 'g', 0x01, 0x12, 0x35, 1};  // the last is the version
constexpr std::array<std::uint8_t, 40> kFlags{};  // compatible and incompatible flags, offsets of appended data
constexpr std::size_t kLongestText = 60'000;

}  // namespace

bool UlogWriter::begin(std::string_view name, TimeUs now) {
  name_ = name;
  waiting_ = 0;
  bytes_ = 0;
  std::array<std::byte, 1> first{};
  open_ = !storage_.read(name, 0, first).has_value();
  put(std::as_bytes(std::span(kMagic)));
  put(static_cast<std::uint64_t>(now));
  message('B', kFlags.size());
  put(std::as_bytes(std::span(kFlags)));
  flush();
  return open_;
}

void UlogWriter::format(std::string_view format) {
  message('F', format.size());
  put(format);
}

void UlogWriter::info(std::string_view key, std::string_view value) {
  value = {value.data(), std::min(value.size(), kLongestText)};  // substr may throw
  std::array<char, 5> digits{};                                  // of the length, lowest first
  std::size_t count = 0;
  for (std::size_t rest = value.size(); rest > 0 || count == 0; rest /= 10) {
    digits[count++] = static_cast<char>('0' + rest % 10);
  }
  constexpr std::string_view kType = "char[";
  constexpr std::string_view kTypeEnd = "] ";
  key = {key.data(), std::min(key.size(), kLongestName)};
  const std::size_t key_size = kType.size() + count + kTypeEnd.size() + key.size();
  message('I', 1 + key_size + value.size());
  put(static_cast<std::uint8_t>(key_size));
  put(kType);
  while (count > 0) put(digits[--count]);
  put(kTypeEnd);
  put(key);
  put(value);
}

void UlogWriter::info(std::string_view key, std::uint32_t value) { pair('I', "uint32_t ", key, value); }

void UlogWriter::parameter(std::string_view key, float value) { pair('P', "float ", key, value); }

void UlogWriter::subscribe(std::uint16_t id, std::string_view name) {
  message('A', 1 + sizeof(id) + name.size());
  put(std::uint8_t{0});  // the first and only instance
  put(id);
  put(name);
}

void UlogWriter::data(std::uint16_t id, std::span<const std::byte> bytes) {
  message('D', sizeof(id) + bytes.size());
  put(id);
  put(bytes);
}

void UlogWriter::text(TimeUs now, std::uint8_t severity, std::string_view text) {
  text = {text.data(), std::min(text.size(), kLongestText)};
  message('L', 1 + sizeof(std::uint64_t) + text.size());
  put(static_cast<char>('0' + std::min<std::uint8_t>(severity, 7)));
  put(static_cast<std::uint64_t>(now));
  put(text);
}

void UlogWriter::flush() {
  if (open_ && waiting_ > 0) open_ = storage_.append(name_, std::span(buffer_).first(waiting_));
  waiting_ = 0;
}

void UlogWriter::message(char type, std::size_t size) {
  put(static_cast<std::uint16_t>(size));
  put(type);
}

void UlogWriter::put(std::span<const std::byte> bytes) {
  while (open_ && !bytes.empty()) {
    const std::size_t count = std::min(bytes.size(), kBuffer - waiting_);
    std::copy_n(bytes.begin(), count, buffer_.begin() + static_cast<std::ptrdiff_t>(waiting_));
    waiting_ += count;
    bytes_ += count;
    bytes = bytes.subspan(count);
    if (waiting_ == kBuffer) flush();
  }
}

}  // namespace swiftlet::companion
