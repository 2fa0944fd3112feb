#include "sim/wire.hpp"

#include <algorithm>

namespace swiftlet::tools {

void Wire::set_faults(const WireFaults& faults) {
  constexpr std::size_t kLongestWait = 64;  // [byte] any byte of a usual message may be the last
  if (faults.cut && !faults_.cut) bytes_until_cut_ = noise_.below(kLongestWait);
  faults_ = faults;
}

void Wire::send(std::span<const std::byte> message, Microseconds now) {
  sent_bytes_ += message.size();
  if (faults_.loss > 0 && noise_.uniform() < faults_.loss) return;
  std::vector<std::byte> bytes(message.begin(), message.end());
  if (faults_.cut) {
    bytes.resize(std::min(bytes.size(), bytes_until_cut_));
    bytes_until_cut_ -= bytes.size();
  }
  if (faults_.corrupt > 0) {
    for (std::byte& byte : bytes) {
      if (noise_.uniform() < faults_.corrupt) byte ^= static_cast<std::byte>(1 + noise_.below(255));
    }
  }
  if (!bytes.empty()) under_way_.push_back({now + delay_, std::move(bytes)});
}

std::vector<std::byte> Wire::receive(Microseconds now) {
  std::vector<std::byte> arrived;
  while (!faults_.stalled && !under_way_.empty() && under_way_.front().due <= now) {
    const std::vector<std::byte>& bytes = under_way_.front().bytes;
    arrived.insert(arrived.end(), bytes.begin(), bytes.end());
    under_way_.pop_front();
  }
  return arrived;
}

}  // namespace swiftlet::tools
