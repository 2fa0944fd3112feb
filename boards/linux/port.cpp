#include "linux/port.hpp"

#include <cerrno>
#include <cstring>
#include <optional>
#include <vector>

#include "cli/failure.hpp"
#include "cli/text.hpp"

namespace swiftlet::board {
namespace {

using tools::ExitStatus;
using tools::Failure;

constexpr std::chrono::microseconds kRetryPeriod{1'000'000};

std::vector<std::string> split_at_colons(const std::string& text) {
  std::vector<std::string> pieces;
  std::size_t begin = 0;
  for (std::size_t colon = text.find(':'); colon != std::string::npos; colon = text.find(':', begin)) {
    pieces.push_back(text.substr(begin, colon - begin));
    begin = colon + 1;
  }
  pieces.push_back(text.substr(begin));
  return pieces;
}

std::uint32_t whole_number(const std::string& text, std::uint32_t most) {
  const std::optional<double> number = tools::parse_number(text);
  const bool usable = number && *number >= 1 && *number <= most && *number == static_cast<std::uint32_t>(*number);
  if (!usable)
    throw Failure{ExitStatus::kUsage, "--port: '" + text + "' is not a number from 1 to " + std::to_string(most)};
  return static_cast<std::uint32_t>(*number);
}

}  // namespace

PortName parse_port(const std::string& text) {
  const std::vector<std::string> pieces = split_at_colons(text);
  if (pieces[0].empty()) throw Failure{ExitStatus::kUsage, "--port: '" + text + "' names no device"};
  PortName name;
  if (pieces[0] != "udp") {
    const std::string& last = pieces.back();
    const bool has_baud = pieces.size() > 1 && last.find_first_not_of("0123456789") == std::string::npos;
    if (has_baud) name.baud = whole_number(last, 12'000'000);
    name.device = has_baud ? text.substr(0, text.size() - last.size() - 1) : text;
    return name;
  }
  if (pieces.size() != 2 && pieces.size() != 4) {
    throw Failure{ExitStatus::kUsage, "--port: '" + text + "' is not udp:PORT or udp:PORT:HOST:PORT"};
  }
  name.local_port = static_cast<std::uint16_t>(whole_number(pieces[1], 65535));
  if (pieces.size() == 4) {
    name.host = pieces[2];
    name.remote_port = static_cast<std::uint16_t>(whole_number(pieces[3], 65535));
  }
  return name;
}

Port::Port(const PortName& name)
    : name_(name), uart_(name.device.empty() ? static_cast<hal::PosixUart&>(udp_) : serial_) {
  if (name.device.empty()) {
    if (udp_.open(name.local_port, name.host.c_str(), name.remote_port)) return;
    throw Failure{ExitStatus::kBadFile,
                  "UDP port " + std::to_string(name.local_port) + " cannot be opened: " + std::strerror(errno)};
  }
  if (serial_.open(name.device.c_str(), name.baud)) return;
  throw Failure{ExitStatus::kBadFile,
                name.device + ": cannot be opened at " + std::to_string(name.baud) + " baud: " + std::strerror(errno)};
}

Port::Change Port::keep(std::chrono::microseconds now) {
  if (uart_.is_open()) return Change::kNone;
  if (!gone_) {
    gone_ = true;
    next_try_ = now + kRetryPeriod;
    return Change::kGone;
  }
  if (now < next_try_) return Change::kNone;
  next_try_ = now + kRetryPeriod;
  if (!serial_.open(name_.device.c_str(), name_.baud)) return Change::kNone;
  gone_ = false;
  return Change::kBack;
}

}  // namespace swiftlet::board
