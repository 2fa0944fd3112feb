#include "swiftlet/hal/region_storage.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace swiftlet::hal {
namespace {

constexpr std::array<char, 8> kMagic{'S', 'W', 'F', 'I', 'L', 'E', 'S', '1'};
constexpr std::uint32_t kOpen = 0xFFFFFFFF;

/// The region's first bytes.
struct Front {
  std::array<char, 8> magic = kMagic;
  std::uint32_t used = sizeof(Front);  // bytes of the region, from its beginning
};

/// In front of a piece's bytes.
struct Header {
  std::array<char, 64> name{};
  std::uint32_t size = kOpen;  // the newest piece reaches to the end of what is used
};

template <typename T>
T load(std::span<const std::byte> region, std::size_t at) {
  T value;
  std::memcpy(&value, region.data() + at, sizeof(T));
  return value;
}

/// In the order of the calls: a reset may come between two.
template <typename T>
void store(std::span<std::byte> region, std::size_t at, const T& value) {
  std::atomic_signal_fence(std::memory_order_seq_cst);
  std::memcpy(region.data() + at, &value, sizeof(T));
  std::atomic_signal_fence(std::memory_order_seq_cst);
}

}  // namespace

RegionStorage::RegionStorage(std::span<std::byte> region) : region_(region), limit_(region.size()) {
  if (region_.size() < sizeof(Front)) {
    region_ = {};
    limit_ = 0;
    return;
  }
  if (!is_whole()) store(region_, 0, Front{});
  find_last();
}

std::size_t RegionStorage::used() const {
  return region_.empty() ? 0 : load<std::uint32_t>(region_, offsetof(Front, used));
}

void RegionStorage::set_used(std::size_t used) {
  store(region_, offsetof(Front, used), static_cast<std::uint32_t>(used));
}

void RegionStorage::set_free_bytes(std::size_t bytes) { limit_ = used() + std::min(bytes, region_.size() - used()); }

/// One that ends at 0 when there is none, or none that is whole.
RegionStorage::Piece RegionStorage::piece_at(std::size_t at) const {
  if (used() < at + sizeof(Header)) return {};
  const std::size_t begin = at + sizeof(Header);
  const auto* const text = reinterpret_cast<const char*>(region_.data() + at);
  const std::string_view name(text, static_cast<std::size_t>(std::find(text, text + 64, '\0') - text));
  const auto size = load<std::uint32_t>(region_, at + offsetof(Header, size));
  const std::size_t end = size == kOpen ? used() : begin + std::min<std::size_t>(size, region_.size());
  if (!is_storage_name(name) || end > used()) return {};
  return {name, region_.subspan(begin, end - begin), at, end};
}

RegionStorage::Piece RegionStorage::first() const { return piece_at(sizeof(Front)); }

bool RegionStorage::is_whole() const {
  if (load<Front>(region_, 0).magic != kMagic || used() < sizeof(Front) || used() > region_.size()) return false;
  std::size_t end = sizeof(Front);
  for (Piece piece = first(); piece.end != 0; piece = piece_at(piece.end)) end = piece.end;
  return end == used();
}

/// The newest piece is open, even if it was closed for another that never came.
void RegionStorage::find_last() {
  last_ = 0;
  for (Piece piece = first(); piece.end != 0; piece = piece_at(piece.end)) last_ = piece.at;
  if (last_ != 0) store(region_, last_ + offsetof(Header, size), kOpen);
}

std::optional<std::size_t> RegionStorage::read(std::string_view name, std::size_t offset, std::span<std::byte> into) {
  bool found = false;
  std::size_t count = 0;
  for (Piece piece = first(); piece.end != 0; piece = piece_at(piece.end)) {
    if (piece.name != name) continue;
    found = true;
    const std::size_t skipped = std::min(offset, piece.bytes.size());
    offset -= skipped;
    const std::size_t taken = std::min(piece.bytes.size() - skipped, into.size() - count);
    std::copy_n(piece.bytes.data() + skipped, taken, into.data() + count);
    count += taken;
  }
  return found ? std::optional(count) : std::nullopt;
}

bool RegionStorage::append(std::string_view name, std::span<const std::byte> bytes) {
  if (!is_storage_name(name)) return false;
  const bool goes_on = last_ != 0 && piece_at(last_).name == name;
  if (!goes_on && !begin_piece(name)) return false;
  const std::size_t count = std::min(bytes.size(), free_bytes());
  std::copy_n(bytes.data(), count, region_.data() + used());
  set_used(used() + count);
  return count == bytes.size();
}

bool RegionStorage::begin_piece(std::string_view name) {
  if (free_bytes() < sizeof(Header)) return false;
  const std::size_t at = used();
  Header header;
  std::copy(name.begin(), name.end(), header.name.begin());
  store(region_, at, header);
  if (last_ != 0) {
    const std::size_t begin = last_ + sizeof(Header);
    store(region_, last_ + offsetof(Header, size), static_cast<std::uint32_t>(at - begin));
  }
  set_used(at + sizeof(Header));
  last_ = at;
  return true;
}

bool RegionStorage::remove(std::string_view name) {
  if (!is_storage_name(name)) return false;
  if (region_.empty()) return true;
  store(region_, 0, std::array<char, 8>{});  // pieces on the move are none that a reset may find
  std::size_t to = sizeof(Front);
  for (Piece piece = first(); piece.end != 0; piece = piece_at(piece.end)) {
    if (piece.name == name) continue;
    std::memmove(region_.data() + to, region_.data() + piece.at, piece.end - piece.at);
    to += piece.end - piece.at;
  }
  set_used(to);
  find_last();
  store(region_, 0, kMagic);
  return true;
}

}  // namespace swiftlet::hal
